// Single operations of arithmetic as kernels of a device: see device_probe.h.
#define __host__ __attribute__((host))
#define __device__ __attribute__((device))

#include <cstdlib>  // first: clang's own <new> needs it

#include <bit>
#include <cstdint>
#include <limits>

#pragma clang force_cuda_host_device begin
#include "tests/bench/device_probe.h"
#pragma clang force_cuda_host_device end

namespace parray::bench {

#define PARRAY_PROBE(name, Real, Operation)                                                 \
  extern "C" __attribute__((global)) void name(std::uint64_t first, std::uint32_t count,    \
                                               Real* results) {                             \
    const std::uint32_t i = __nvvm_read_ptx_sreg_ctaid_x() * __nvvm_read_ptx_sreg_ntid_x() + \
                            __nvvm_read_ptx_sreg_tid_x();                                   \
    if (i < count) results[i] = probe<Real, Operation>(first + i);                          \
  }
PARRAY_FOR_EACH_DEVICE_PROBE(PARRAY_PROBE)
#undef PARRAY_PROBE

}  // namespace parray::bench
