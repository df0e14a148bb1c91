#pragma once

#include <cstddef>

#include "tests/support/rooms.h"

/// The part of CUDA's driver library that ParRay uses, declared by hand. The binary interface of
/// these functions is fixed: a newer version of a function gets a new suffix.
namespace parray::test::cuda {

using Result = int;
using DeviceNumber = int;
using Pointer = unsigned long long;  ///< an address in the device's memory
using Context = struct ContextState*;
using Module = struct ModuleState*;
using Function = struct FunctionState*;
using Stream = struct StreamState*;  ///< null: the default stream
using Event = struct EventState*;

inline constexpr Result success = 0;
inline constexpr Result invalid_value = 1;
inline constexpr Result out_of_memory = 2;
inline constexpr Result not_initialized = 3;
inline constexpr Result no_device = 100;
inline constexpr Result invalid_device = 101;
inline constexpr Result invalid_context = 201;
inline constexpr Result invalid_ptx = 218;
inline constexpr Result invalid_handle = 400;
inline constexpr Result not_found = 500;
inline constexpr Result illegal_address = 700;
inline constexpr Result launch_failed = 719;

enum DeviceAttribute {
  clock_khz = 13,
  multiprocessors = 16,
  ecc = 32,
  memory_clock_khz = 36,
  memory_bus_bits = 37,
  l2_bytes = 38,
  capability_major = 75,
  capability_minor = 76,
};

enum FunctionAttribute { local_bytes = 3, registers = 4 };

enum JitOption {
  most_registers = 0,
  error_log = 5,
  error_log_bytes = 6,
};

/// F(symbol, parameters...) for each function. All of them return a Result.
#define PARRAY_FOR_EACH_CUDA_FUNCTION(F)                                                        \
  F(cuInit, unsigned flags)                                                                     \
  F(cuDriverGetVersion, int* version)                                                           \
  F(cuGetErrorName, Result error, const char** name)                                            \
  F(cuDeviceGetCount, int* count)                                                               \
  F(cuDeviceGet, DeviceNumber* device, int ordinal)                                             \
  F(cuDeviceGetName, char* name, int size, DeviceNumber device)                                 \
  F(cuDeviceTotalMem_v2, std::size_t* bytes, DeviceNumber device)                               \
  F(cuDeviceGetAttribute, int* value, DeviceAttribute attribute, DeviceNumber device)           \
  F(cuDevicePrimaryCtxRetain, Context* context, DeviceNumber device)                            \
  F(cuDevicePrimaryCtxRelease_v2, DeviceNumber device)                                          \
  F(cuCtxSetCurrent, Context context)                                                           \
  F(cuCtxSynchronize)                                                                           \
  F(cuModuleLoadDataEx, Module* module, const void* image, unsigned option_count,               \
    JitOption* options, void** values)                                                          \
  F(cuModuleUnload, Module module)                                                              \
  F(cuModuleGetFunction, Function* function, Module module, const char* name)                   \
  F(cuFuncGetAttribute, int* value, FunctionAttribute attribute, Function function)             \
  F(cuOccupancyMaxActiveBlocksPerMultiprocessor, int* blocks, Function function,                \
    int block_threads, std::size_t shared_bytes)                                                \
  F(cuMemAlloc_v2, Pointer* memory, std::size_t bytes)                                          \
  F(cuMemFree_v2, Pointer memory)                                                               \
  F(cuMemcpyHtoD_v2, Pointer to, const void* from, std::size_t bytes)                           \
  F(cuMemcpyDtoH_v2, void* to, Pointer from, std::size_t bytes)                                 \
  F(cuLaunchKernel, Function function, unsigned grid_x, unsigned grid_y, unsigned grid_z,       \
    unsigned block_x, unsigned block_y, unsigned block_z, unsigned shared_bytes, Stream stream, \
    void** parameters, void** extra)                                                            \
  F(cuEventCreate, Event* event, unsigned flags)                                                \
  F(cuEventDestroy_v2, Event event)                                                             \
  F(cuEventRecord, Event event, Stream stream)                                                  \
  F(cuEventSynchronize, Event event)                                                            \
  F(cuEventElapsedTime, float* milliseconds, Event begin, Event end)

/// Pointers to the functions.
struct Functions {
#define PARRAY_CUDA_POINTER(name, ...) Result (*name)(__VA_ARGS__) = nullptr;
  PARRAY_FOR_EACH_CUDA_FUNCTION(PARRAY_CUDA_POINTER)
#undef PARRAY_CUDA_POINTER
};

}  // namespace parray::test::cuda
