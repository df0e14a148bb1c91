#pragma once

#include <cstdint>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "tests/support/cuda/cuda_launcher.h"

/// Whether a device computes the bits of the CPU. Each check prints a line and returns figures.
namespace parray::bench {

using Json = nlohmann::ordered_json;

/// Collects what a device computes wrongly.
class Verdict {
 public:
  /// Prints the line "WRONG: ...".
  void wrong(const std::string& what);
  [[nodiscard]] const std::vector<std::string>& found() const { return found_; }

 private:
  std::vector<std::string> found_;
};

struct PictureSize {
  std::uint32_t width = 60;
  std::uint32_t height = 40;
  std::uint32_t samples = 8;
};

/// Compares the device's fingerprint with the pinned one and with the CPU's.
Json check_fingerprint(const test::CudaLauncher& device, Verdict& verdict);

/// Traces every scene of the folder `scenes` in all precisions, with all samplers and both
/// searches, and compares all sums with the CPU's.
Json check_pictures(const std::filesystem::path& scenes, const PictureSize& size,
                    const test::CudaLauncher& device, Verdict& verdict);

/// Computes `count` random divisions and square roots, and a tenth as many of each group of other
/// operations, and compares their bits with the CPU's. `probes` has the kernels of device_probe.cu.
Json check_operations(std::uint64_t count, const test::CudaDevice& device,
                      const test::CudaModule& probes, Verdict& verdict);

}  // namespace parray::bench
