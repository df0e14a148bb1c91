// Kernels of a device. Clang compiles them to PTX (-x cuda) and to SPIR-V (-x hip), without the
// libraries of a vendor.
#define __host__ __attribute__((host))
#define __device__ __attribute__((device))

#include <cstdlib>  // first: clang's own <new> needs it

#include <algorithm>
#include <array>
#include <bit>
#include <concepts>
#include <cstdint>
#include <limits>
#include <optional>
#include <span>
#include <string_view>
#include <utility>
#include <vector>

#pragma clang force_cuda_host_device begin
#include "common/trace/device/device_entry.h"
#pragma clang force_cuda_host_device end

#ifndef __NVPTX__
__device__ std::size_t get_global_id(unsigned);  // OpenCL's
#endif

namespace parray::trace {

__device__ inline std::uint32_t thread_number() {
#ifdef __NVPTX__
  return __nvvm_read_ptx_sreg_ctaid_x() * __nvvm_read_ptx_sreg_ntid_x() +
         __nvvm_read_ptx_sreg_tid_x();
#else
  return static_cast<std::uint32_t>(get_global_id(0));
#endif
}

#define PARRAY_KERNEL(name, Real, Store, Search, most_inside)                                    \
  extern "C" __attribute__((global)) void name(const void* scene, const void* picture,           \
                                               const DeviceItem* items, std::uint32_t item_count, \
                                               DeviceSums* sums) {                               \
    const std::uint32_t i = thread_number();                                                     \
    if (i < item_count) {                                                                        \
      trace_item<Real, Store, Search, most_inside>(scene, picture, items[i], sums[i]);           \
    }                                                                                            \
  }
PARRAY_FOR_EACH_DEVICE_KERNEL(PARRAY_KERNEL)
#undef PARRAY_KERNEL

}  // namespace parray::trace
