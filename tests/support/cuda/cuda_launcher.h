#pragma once

#include <cstdint>

#include "tests/support/cuda/cuda_device.h"
#include "tests/support/device_picture.h"

namespace parray::test {

/// Traces launches on a CUDA device, one after the other: a Launcher. The module and the device
/// must outlive it.
class CudaLauncher {
 public:
  CudaLauncher(const CudaDevice& device, const CudaModule& module)
      : device_(device), module_(module) {}

  void operator()(const Launch& launch) const {
    constexpr std::uint32_t block = 128;
    const CudaDriver& driver = device_.driver();
    const CudaMemory scene(driver, launch.scene);
    const CudaMemory picture(driver, launch.picture);
    const CudaMemory items(driver, std::as_bytes(launch.items));
    // Copied, so that sums that the kernel does not write cannot be right by chance.
    const CudaMemory sums(driver, std::as_bytes(launch.sums));
    const auto count = static_cast<std::uint32_t>(launch.items.size());
    device_.launch(module_.kernel(launch.kernel), count, block, scene.address(), picture.address(),
                   items.address(), count, sums.address());
    device_.wait();
    sums.copy_out(std::as_writable_bytes(launch.sums));
  }

 private:
  const CudaDevice& device_;
  const CudaModule& module_;
};

}  // namespace parray::test
