#pragma once

#include <sched.h>
#include <time.h>

#include <algorithm>
#include <cstdint>
#include <cstdio>
#include <fstream>
#include <string>
#include <vector>

#include "common/scene/settings.h"
#include "tests/support/rooms.h"

/// What the benchmarks share. They run on one core and print medians of rounds in which variants
/// take turns, so that a machine whose speed drifts drifts for all.
namespace parray::bench {

inline constexpr std::size_t rounds = 7;
inline constexpr double seconds_a_turn = 0.3;

/// 300 x 200 pixels, depth 10, independent samples, as the rivals have them; precision and
/// accelerator are left automatic.
inline RenderSettings small_picture() {
  RenderSettings settings;
  settings.width = 300;
  settings.height = 200;
  settings.max_depth = 10;
  settings.sampler = Sampler::independent;
  return settings;
}

/// The row to trace at a step: rows spread over the picture, each once in 200 steps.
inline std::uint32_t row_at(std::size_t step, const RenderSettings& settings) {
  return static_cast<std::uint32_t>(step * 67 % settings.height);  // 67 and 200 share no factor
}

/// The upper median; `values` is not empty.
inline double median(std::vector<double> values) {
  std::sort(values.begin(), values.end());
  return values[values.size() / 2];
}

/// Seconds of processor that this process has had. Unlike the time of day, they do not pass while
/// another process has the core.
inline double cpu_seconds() {
  timespec now{};
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &now);
  return static_cast<double>(now.tv_sec) + static_cast<double>(now.tv_nsec) * 1e-9;
}

/// Keeps this thread, and those that it starts, on the last core that it may use.
inline void pin_to_one_core() {
  cpu_set_t allowed;
  CPU_ZERO(&allowed);
  sched_getaffinity(0, sizeof allowed, &allowed);
  for (int cpu = CPU_SETSIZE - 1; cpu >= 0; --cpu) {
    if (CPU_ISSET(cpu, &allowed)) {
      cpu_set_t one;
      CPU_ZERO(&one);
      CPU_SET(cpu, &one);
      sched_setaffinity(0, sizeof one, &one);
      return;
    }
  }
}

/// Says so on standard output where this is a build whose figures mean nothing.
inline void warn_of_assertions() {
#ifndef NDEBUG
  std::puts("warning: built with assertions; these figures mean nothing");
#endif
}

/// The processor's name, as the kernel has it.
inline std::string processor() {
  std::ifstream info("/proc/cpuinfo");
  for (std::string line; std::getline(info, line);) {
    if (line.starts_with("model name")) return line.substr(line.find(':') + 2);
  }
  return "unknown processor";
}

}  // namespace parray::bench
