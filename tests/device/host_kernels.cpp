#include "tests/device/host_kernels.h"

#include <map>

#include "common/trace/device/device_entry.h"

namespace parray::test {
namespace {

using Kernel = void (*)(const void* scene, const void* picture, const DeviceItem& item,
                        DeviceSums& sums);

/// Returns the kernels by name. Kernels of a device have a stack for 0 or 8 shapes.
const std::map<std::string, Kernel>& kernels() {
  static const std::map<std::string, Kernel> all = {
#define PARRAY_KERNEL(name, Real, Store, Search, most_inside) \
  {#name, trace_item<Real, Store, Search, most_inside>},
      PARRAY_FOR_EACH_DEVICE_KERNEL(PARRAY_KERNEL)
#undef PARRAY_KERNEL
#define PARRAY_SHORT_KERNELS(precision, Real, Store)                               \
  {"trace_" #precision "_linear_1", trace_item<Real, Store, DeviceLinear, 1>},     \
      {"trace_" #precision "_linear_2", trace_item<Real, Store, DeviceLinear, 2>}, \
      {"trace_" #precision "_bvh_1", trace_item<Real, Store, DeviceTree, 1>},      \
      {"trace_" #precision "_bvh_2", trace_item<Real, Store, DeviceTree, 2>},
          PARRAY_SHORT_KERNELS(f32, float, float) PARRAY_SHORT_KERNELS(mixed, double, float)
              PARRAY_SHORT_KERNELS(f64, double, double)
#undef PARRAY_SHORT_KERNELS
  };
  return all;
}

}  // namespace

void launch_on_host(const Launch& launch) {
  const Kernel kernel = kernels().at(launch.kernel);
  for (std::size_t i = 0; i < launch.items.size(); ++i) {
    kernel(launch.scene.data(), launch.picture.data(), launch.items[i], launch.sums[i]);
  }
}

void launch_on_host(const Launch& launch, std::uint32_t most_inside) {
  Launch other = launch;
  other.kernel =
      launch.kernel.substr(0, launch.kernel.rfind('_') + 1) + std::to_string(most_inside);
  launch_on_host(other);
}

}  // namespace parray::test
