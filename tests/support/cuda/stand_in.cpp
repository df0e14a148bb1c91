// A stand-in for CUDA's driver library, for machines without a GPU: the processor runs the kernels.
// It refuses wrong handles, addresses, sizes and alignments as a driver does, or more strictly, and
// says so on stderr.
//
// The environment variable PARRAY_CUDA_STAND_IN makes it fail:
//   no_device        cuInit() finds no device
//   out_of_memory    no memory can be taken
//   launch_fails     every launch is accepted and fails later
//   invalid_ptx      the compiler refuses every module
//   skip KERNEL      each launch of KERNEL computes nothing
//   flip KERNEL      one bit in the results of each launch of KERNEL is wrong
#include <algorithm>
#include <array>
#include <atomic>
#include <bit>
#include <chrono>
#include <cstdlib>
#include <cstring>
#include <iostream>
#include <map>
#include <memory>
#include <mutex>
#include <new>
#include <set>
#include <string>
#include <string_view>
#include <thread>
#include <type_traits>
#include <utility>
#include <vector>

#include "common/math/float_mode.h"
#include "tests/support/cuda/stand_in_kernels.h"

namespace parray::test::cuda {

struct ContextState {};
struct ModuleState {
  std::string text;
};
struct FunctionState {
  std::string name;
  stand_in::KernelBinder bind;
};
struct EventState {
  std::chrono::steady_clock::time_point time;
};

}  // namespace parray::test::cuda

namespace {

using namespace parray;
using namespace parray::test;
using namespace parray::test::cuda;
using namespace parray::test::stand_in;

/// A block of the device's memory, aligned as by CUDA.
class Block {
 public:
  explicit Block(std::size_t bytes) : data_(operator new(bytes, alignment)), bytes_(bytes) {}
  ~Block() { operator delete(data_, alignment); }
  Block& operator=(Block&&) = delete;

  [[nodiscard]] void* data() const { return data_; }
  [[nodiscard]] std::size_t size() const { return bytes_; }

 private:
  static constexpr std::align_val_t alignment{256};
  void* data_;
  std::size_t bytes_;
};

/// The library's only device with everything that a program has made on it.
struct StandIn {
  std::mutex mutex;
  bool begun = false;
  bool current = false;     ///< the context is retained and set
  Result sticky = success;  ///< the error of a launch: all later calls return it
  ContextState context;
  std::map<Pointer, std::unique_ptr<Block>> memory;
  std::map<Module, std::unique_ptr<ModuleState>> modules;
  std::map<Function, std::unique_ptr<FunctionState>> functions;
  std::map<Event, std::unique_ptr<EventState>> events;
};

StandIn& state() {
  static StandIn all;
  return all;
}

std::string_view fault() {
  const char* given = std::getenv("PARRAY_CUDA_STAND_IN");  // NOLINT(concurrency-mt-unsafe)
  return given == nullptr ? "" : given;
}

/// Says what is wrong with a call and returns `result`.
Result refuse(Result result, const char* what) {
  std::cerr << "CUDA stand-in: " << what << "\n";
  return result;
}

/// Does the work of a function that needs a context.
template <typename Work>
Result in_context(const Work& work) {
  StandIn& all = state();
  const std::lock_guard lock(all.mutex);
  if (!all.begun) return not_initialized;
  if (!all.current) return invalid_context;
  if (all.sticky != success) return all.sticky;
  return work(all);
}

/// Returns whether a block of memory has all bytes [address, address + bytes).
bool has_bytes(const StandIn& all, Pointer address, std::size_t bytes) {
  auto after = all.memory.upper_bound(address);
  if (after == all.memory.begin()) return false;
  const auto& [begin, block] = *std::prev(after);
  return address - begin <= block->size() && bytes <= block->size() - (address - begin);
}

Result check_buffers(const StandIn& all, const BoundKernel& kernel) {
  for (const BufferUse& use : kernel.buffers) {
    if (use.address % use.alignment != 0) return refuse(illegal_address, "misaligned address");
    if (!has_bytes(all, use.address, use.bytes)) {
      return refuse(illegal_address, "a kernel would leave its block of memory");
    }
  }
  return success;
}

/// Runs all threads of a grid on the processors.
void run_grid(const BoundKernel& kernel, std::uint32_t threads) {
  constexpr std::uint32_t piece = 256;
  std::atomic<std::uint32_t> next = 0;
  const auto work = [&] {
    const FloatMode ieee;
    for (std::uint32_t begin = next.fetch_add(piece); begin < threads;
         begin = next.fetch_add(piece)) {
      for (std::uint32_t i = begin; i < std::min(threads, begin + piece); ++i) kernel.run_thread(i);
    }
  };
  std::vector<std::jthread> helpers;
  const unsigned processors = std::clamp(std::thread::hardware_concurrency(), 1U, 16U);
  for (unsigned i = 1; i < processors && i * piece < threads; ++i) helpers.emplace_back(work);
  work();
}

/// Flips a bit in the middle of the results.
void flip_bit(const BoundKernel& kernel) {
  const BufferUse& results = kernel.buffers.back();
  if (results.bytes == 0) return;
  *std::bit_cast<unsigned char*>(results.address + results.bytes / 2) ^= 1;
}

Result launch(StandIn& all, Function function, unsigned grid, unsigned block, void** parameters) {
  const auto known = all.functions.find(function);
  if (known == all.functions.end()) return refuse(invalid_handle, "launch of an unknown function");
  if (grid == 0 || block == 0 || block > 1024) {
    return refuse(invalid_value, "launch of an empty grid or of a block above 1024 threads");
  }
  const BoundKernel kernel = known->second->bind(parameters);
  if (fault() == "launch_fails") {
    all.sticky = launch_failed;
    return success;
  }
  const Result checked = check_buffers(all, kernel);
  if (checked != success) {
    all.sticky = checked;
    return success;
  }
  if (fault() == "skip " + known->second->name) return success;
  run_grid(kernel, grid * block);
  if (fault() == "flip " + known->second->name) flip_bit(kernel);
  return success;
}

constexpr std::array<std::pair<Result, const char*>, 12> error_names{
    {{success, "CUDA_SUCCESS"},
     {invalid_value, "CUDA_ERROR_INVALID_VALUE"},
     {out_of_memory, "CUDA_ERROR_OUT_OF_MEMORY"},
     {not_initialized, "CUDA_ERROR_NOT_INITIALIZED"},
     {no_device, "CUDA_ERROR_NO_DEVICE"},
     {invalid_device, "CUDA_ERROR_INVALID_DEVICE"},
     {invalid_context, "CUDA_ERROR_INVALID_CONTEXT"},
     {invalid_ptx, "CUDA_ERROR_INVALID_PTX"},
     {invalid_handle, "CUDA_ERROR_INVALID_HANDLE"},
     {not_found, "CUDA_ERROR_NOT_FOUND"},
     {illegal_address, "CUDA_ERROR_ILLEGAL_ADDRESS"},
     {launch_failed, "CUDA_ERROR_LAUNCH_FAILED"}}};

Result attribute_of(DeviceAttribute attribute, int& value) {
  static const std::map<DeviceAttribute, int> values = {
      {clock_khz, 1'000'000},        {multiprocessors, 2},  {ecc, 1},
      {memory_clock_khz, 1'000'000}, {memory_bus_bits, 64}, {l2_bytes, 1 << 20},
      {capability_major, 9},         {capability_minor, 0}};
  const auto found = values.find(attribute);
  if (found == values.end()) return invalid_value;
  value = found->second;
  return success;
}

/// Refuses a text that is not PTX, and options that are unknown.
Result check_module(const char* text, unsigned count, const JitOption* options) {
  if (fault() == "invalid_ptx") return invalid_ptx;
  if (!std::string_view(text).starts_with("//")) return refuse(invalid_ptx, "the text is not PTX");
  for (unsigned i = 0; i < count; ++i) {
    if (options[i] != most_registers && options[i] != error_log && options[i] != error_log_bytes) {
      return refuse(invalid_value, "unknown option of the compiler");
    }
  }
  return success;
}

}  // namespace

// NOLINTBEGIN(readability-identifier-naming): the library's names
extern "C" {

Result cuInit(unsigned flags) {
  if (flags != 0) return invalid_value;
  if (fault() == "no_device") return no_device;
  state().begun = true;
  return success;
}

Result cuDriverGetVersion(int* version) {
  *version = 12'040;
  return success;
}

Result cuGetErrorName(Result error, const char** name) {
  for (const auto& [known, text] : error_names) {
    if (known == error) {
      *name = text;
      return success;
    }
  }
  return invalid_value;
}

Result cuDeviceGetCount(int* count) {
  *count = 1;
  return state().begun ? success : not_initialized;
}

Result cuDeviceGet(DeviceNumber* device, int ordinal) {
  *device = 0;
  return ordinal == 0 ? success : invalid_device;
}

Result cuDeviceGetName(char* name, int size, DeviceNumber device) {
  if (device != 0) return invalid_device;
  constexpr std::string_view text = "stand-in for a CUDA device";
  name[text.copy(name, static_cast<std::size_t>(size) - 1)] = '\0';
  return success;
}

Result cuDeviceTotalMem_v2(std::size_t* bytes, DeviceNumber device) {
  *bytes = std::size_t{1} << 30;
  return device == 0 ? success : invalid_device;
}

Result cuDeviceGetAttribute(int* value, DeviceAttribute attribute, DeviceNumber device) {
  return device == 0 ? attribute_of(attribute, *value) : invalid_device;
}

Result cuDevicePrimaryCtxRetain(Context* context, DeviceNumber device) {
  if (device != 0) return invalid_device;
  *context = &state().context;
  return success;
}

Result cuDevicePrimaryCtxRelease_v2(DeviceNumber device) {
  const StandIn& all = state();
  if (!all.memory.empty()) return refuse(invalid_value, "the program keeps memory of the device");
  if (!all.modules.empty()) return refuse(invalid_value, "the program keeps a module");
  if (!all.events.empty()) return refuse(invalid_value, "the program keeps an event");
  return device == 0 ? success : invalid_device;
}

Result cuCtxSetCurrent(Context context) {
  if (context != nullptr && context != &state().context) return invalid_context;
  state().current = context != nullptr;
  return success;
}

Result cuCtxSynchronize() {
  return in_context([](StandIn&) { return success; });
}

Result cuModuleLoadDataEx(Module* module, const void* image, unsigned option_count,
                          JitOption* options, void**) {
  return in_context([&](StandIn& all) {
    const auto* text = static_cast<const char*>(image);
    const Result checked = check_module(text, option_count, options);
    if (checked != success) return checked;
    auto made = std::make_unique<ModuleState>(ModuleState{text});
    *module = made.get();
    all.modules.emplace(made.get(), std::move(made));
    return success;
  });
}

Result cuModuleUnload(Module module) {
  const std::lock_guard lock(state().mutex);
  return state().modules.erase(module) == 1 ? success : refuse(invalid_handle, "unknown module");
}

Result cuModuleGetFunction(Function* function, Module module, const char* name) {
  return in_context([&](StandIn& all) {
    const auto known = all.modules.find(module);
    if (known == all.modules.end()) return refuse(invalid_handle, "unknown module");
    const auto bind = find_kernel(name);
    const std::string entry = ".entry " + std::string(name) + "(";
    if (bind == nullptr || known->second->text.find(entry) == std::string::npos) return not_found;
    auto made = std::make_unique<FunctionState>(FunctionState{name, bind});
    *function = made.get();
    all.functions.emplace(made.get(), std::move(made));
    return success;
  });
}

Result cuFuncGetAttribute(int* value, FunctionAttribute attribute, Function) {
  *value = attribute == registers ? 32 : 0;
  return success;
}

Result cuOccupancyMaxActiveBlocksPerMultiprocessor(int* blocks, Function, int block_threads,
                                                   std::size_t) {
  if (block_threads < 1 || block_threads > 1024) return invalid_value;
  *blocks = 2048 / block_threads;
  return success;
}

Result cuMemAlloc_v2(Pointer* memory, std::size_t bytes) {
  return in_context([&](StandIn& all) {
    if (bytes == 0) return refuse(invalid_value, "a block of memory without bytes");
    if (fault() == "out_of_memory") return out_of_memory;
    auto block = std::make_unique<Block>(bytes);
    std::memset(block->data(), 0xA5, bytes);  // memory of a device has no value
    *memory = reinterpret_cast<Pointer>(block->data());
    all.memory.emplace(*memory, std::move(block));
    return success;
  });
}

Result cuMemFree_v2(Pointer memory) {
  const std::lock_guard lock(state().mutex);
  return state().memory.erase(memory) == 1 ? success : refuse(invalid_value, "unknown memory");
}

Result cuMemcpyHtoD_v2(Pointer to, const void* from, std::size_t bytes) {
  return in_context([&](StandIn& all) {
    if (!has_bytes(all, to, bytes)) return refuse(invalid_value, "copy beyond a block of memory");
    std::memcpy(std::bit_cast<void*>(to), from, bytes);
    return success;
  });
}

Result cuMemcpyDtoH_v2(void* to, Pointer from, std::size_t bytes) {
  return in_context([&](StandIn& all) {
    if (!has_bytes(all, from, bytes)) return refuse(invalid_value, "copy beyond a block of memory");
    std::memcpy(to, std::bit_cast<const void*>(from), bytes);
    return success;
  });
}

Result cuLaunchKernel(Function function, unsigned grid_x, unsigned grid_y, unsigned grid_z,
                      unsigned block_x, unsigned block_y, unsigned block_z, unsigned shared_bytes,
                      Stream stream, void** parameters, void** extra) {
  return in_context([&](StandIn& all) {
    if (grid_y != 1 || grid_z != 1 || block_y != 1 || block_z != 1 || shared_bytes != 0 ||
        stream != nullptr || extra != nullptr) {
      return refuse(invalid_value, "a launch that ParRay's kernels do not know");
    }
    return launch(all, function, grid_x, block_x, parameters);
  });
}

Result cuEventCreate(Event* event, unsigned) {
  return in_context([&](StandIn& all) {
    auto made = std::make_unique<EventState>();
    *event = made.get();
    all.events.emplace(made.get(), std::move(made));
    return success;
  });
}

Result cuEventDestroy_v2(Event event) {
  const std::lock_guard lock(state().mutex);
  return state().events.erase(event) == 1 ? success : refuse(invalid_handle, "unknown event");
}

Result cuEventRecord(Event event, Stream) {
  return in_context([&](StandIn&) {
    event->time = std::chrono::steady_clock::now();
    return success;
  });
}

Result cuEventSynchronize(Event) {
  return in_context([](StandIn&) { return success; });
}

Result cuEventElapsedTime(float* milliseconds, Event begin, Event end) {
  return in_context([&](StandIn&) {
    *milliseconds = std::chrono::duration<float, std::milli>(end->time - begin->time).count();
    return success;
  });
}

}  // extern "C"
// NOLINTEND(readability-identifier-naming)

#define PARRAY_CUDA_SAME(name, ...) \
  static_assert(std::is_same_v<decltype(&name), decltype(Functions::name)>);
PARRAY_FOR_EACH_CUDA_FUNCTION(PARRAY_CUDA_SAME)
#undef PARRAY_CUDA_SAME
