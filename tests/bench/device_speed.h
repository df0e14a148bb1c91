#pragma once

#include <chrono>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "common/scene/setting_choices.h"
#include "tests/bench/device_checks.h"

namespace parray::bench {

/// The goal of the device code, in samples per second: at goal_spheres spheres in f32.
inline constexpr double goal = 0.5e9;
inline constexpr std::uint32_t goal_spheres = 486;

/// Time that a program may still take.
class TimeLimit {
 public:
  explicit TimeLimit(double seconds) : limit_(seconds) {}
  [[nodiscard]] double used() const {
    return std::chrono::duration<double>(std::chrono::steady_clock::now() - begin_).count();
  }
  [[nodiscard]] bool allows(double more) const { return used() + more <= limit_; }

 private:
  std::chrono::steady_clock::time_point begin_ = std::chrono::steady_clock::now();
  double limit_;
};

struct SpeedOptions {
  std::vector<std::uint32_t> spheres;
  std::vector<Precision> precisions;
  std::vector<int> caps;              ///< most registers of a thread; 0: the driver chooses
  std::vector<std::uint32_t> blocks;  ///< threads of a block
  std::uint32_t width = 960;
  std::uint32_t height = 640;
  double launch_seconds = 0.03;  ///< about the time of a launch
  std::size_t rounds = 5;        ///< launches of each cell of the table
  double cpu_seconds = 0.3;      ///< of each of the CPU's rounds
  std::size_t cpu_rounds = 3;
  std::filesystem::path generated;  ///< folder of one-weekend-N.json
};

/// The tracing kernels, compiled with each limit of registers when they are first needed.
class ModulesByCap {
 public:
  ModulesByCap(const test::CudaDevice& device, std::string ptx)
      : device_(device), ptx_(std::move(ptx)) {}

  const test::CudaModule& with(int cap);
  /// Returns the seconds that the driver's compiler took, for each limit.
  [[nodiscard]] Json compile_seconds() const { return seconds_; }

 private:
  const test::CudaDevice& device_;
  std::string ptx_;
  std::map<int, std::unique_ptr<test::CudaModule>> modules_;
  Json seconds_ = Json::object();
};

/// Returns the name of a limit of registers, "none" for 0.
std::string name_of_cap(int cap);

/// Measures samples per second of the device by scene, precision, limit of registers and size of
/// blocks, and of one core of the CPU. Compares some sums of every picture with the CPU's. Leaves
/// rows out when the time is over, and says so. Calls `keep` with all figures so far after each
/// scene and precision.
void measure_speed(const SpeedOptions& options, const TimeLimit& time,
                   const test::CudaDevice& device, ModulesByCap& modules, Verdict& verdict,
                   const std::function<void(const Json&)>& keep);

/// Measures how the division into items changes the speed, at goal_spheres spheres in f32 with the
/// limit `cap` and blocks of `block` threads; and the time of an empty launch and of copies.
Json measure_launches(const SpeedOptions& options, int cap, std::uint32_t block,
                      const test::CudaDevice& device, ModulesByCap& modules);

}  // namespace parray::bench
