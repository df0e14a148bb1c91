#include "tests/support/cuda/stand_in_kernels.h"

#include <bit>
#include <map>

#include "common/trace/device/device_entry.h"
#include "tests/bench/device_probe.h"

namespace parray::test::stand_in {

using namespace bench;  // the operations

namespace {

template <typename T>
T parameter(void** parameters, int number) {
  return *static_cast<const T*>(parameters[number]);
}

template <typename T>
T* place(cuda::Pointer address) {
  return std::bit_cast<T*>(address);
}

template <typename Real, typename Store, template <typename, typename> class Search,
          std::uint32_t most_inside>
BoundKernel bind_trace(void** parameters) {
  const auto scene = parameter<cuda::Pointer>(parameters, 0);
  const auto picture = parameter<cuda::Pointer>(parameters, 1);
  const auto items = parameter<cuda::Pointer>(parameters, 2);
  const auto count = parameter<std::uint32_t>(parameters, 3);
  const auto sums = parameter<cuda::Pointer>(parameters, 4);
  constexpr std::size_t line = 64;
  return {{{scene, line, line},
           {picture, line, line},
           {items, count * sizeof(DeviceItem), alignof(DeviceItem)},
           {sums, count * sizeof(DeviceSums), alignof(DeviceSums)}},
          [=](std::uint32_t thread) {
            if (thread >= count) return;
            trace_item<Real, Store, Search, most_inside>(
                place<const void>(scene), place<const void>(picture),
                place<const DeviceItem>(items)[thread], place<DeviceSums>(sums)[thread]);
          }};
}

template <typename Real, typename Operation>
BoundKernel bind_probe(void** parameters) {
  const auto first = parameter<std::uint64_t>(parameters, 0);
  const auto count = parameter<std::uint32_t>(parameters, 1);
  const auto results = parameter<cuda::Pointer>(parameters, 2);
  return {{{results, count * sizeof(Real), alignof(Real)}}, [=](std::uint32_t thread) {
            if (thread >= count) return;
            reinterpret_cast<Real*>(results)[thread] =
                bench::probe<Real, Operation>(first + thread);
          }};
}

const std::map<std::string, KernelBinder>& kernels() {
  static const std::map<std::string, KernelBinder> all = {
#define PARRAY_KERNEL(name, Real, Store, Search, most_inside) \
  {#name, bind_trace<Real, Store, Search, most_inside>},
      PARRAY_FOR_EACH_DEVICE_KERNEL(PARRAY_KERNEL)
#undef PARRAY_KERNEL
#define PARRAY_PROBE(name, Real, Operation) {#name, bind_probe<Real, Operation>},
          PARRAY_FOR_EACH_DEVICE_PROBE(PARRAY_PROBE)
#undef PARRAY_PROBE
  };
  return all;
}

}  // namespace

KernelBinder find_kernel(const std::string& name) {
  const auto found = kernels().find(name);
  return found == kernels().end() ? nullptr : found->second;
}

}  // namespace parray::test::stand_in
