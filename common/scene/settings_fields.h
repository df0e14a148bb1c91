#pragma once

#include <array>
#include <cstdint>
#include <limits>
#include <string_view>

#include "common/scene/limits.h"
#include "common/scene/setting_rules.h"
#include "common/scene/settings.h"

/// Describes every setting: key, help, range and words. Options, scene files, messages, recipes,
/// reports, the HTTP service, the schema of scenes and the keywords of Python come from this
/// description. Few sources include this header; all others use settings.h.
///
/// A description calls the visitor `f(const Setting&, rule, values...)` for each setting. The rule
/// defines the valid values. `values` are the same member of all objects passed to the description:
/// no object, one object, or two that are compared or copied.
namespace parray::scene {

namespace words {
inline constexpr std::array<std::string_view, 2> samplers{"independent", "sobol"};
inline constexpr std::array<std::string_view, 4> precisions{"auto", "f32", "f64", "mixed"};
inline constexpr std::array<std::string_view, 4> accelerators{"auto", "linear", "bvh", "octree"};
inline constexpr std::array<std::string_view, 5> isas{"auto", "scalar", "avx2", "avx512", "neon"};
inline constexpr std::array<std::string_view, 4> schedules{"static", "guided", "factoring",
                                                           "weighted"};
inline constexpr std::array<std::string_view, 3> row_orders{"auto", "sequential", "interleaved"};

inline constexpr Words sampler{"sampler", samplers};
inline constexpr Words precision{"precision", precisions};
inline constexpr Words accelerator{"accelerator", accelerators};
inline constexpr Words isa{"instruction set", isas};
inline constexpr Words schedule{"schedule", schedules};
inline constexpr Words row_order{"row order", row_orders};
}  // namespace words

template <typename F, typename... S>
void size_fields(F&& f, S&... s) {
  using namespace traits;
  constexpr IntegerRange sides{1, limits::max_image_side};
  f({"width", "Pixels across", image | recipe}, sides, s.width...);
  f({"height", "Pixels down", image | recipe}, sides, s.height...);
}

template <typename F, typename... S>
void picture_fields(F&& f, S&... s) {
  using namespace traits;
  size_fields(f, s...);
  f({"max_depth", "Longest path, in ray segments", render | recipe},
    IntegerRange{1, limits::max_depth}, s.max_depth...);
  f({"seed", "Another seed gives other noise", render | recipe},
    IntegerRange{0, std::numeric_limits<std::uint64_t>::max()}, s.seed...);
  f({"sampler",
     "Random numbers of a pixel's samples: independent of each other, or evenly spread "
     "(Owen-scrambled Sobol)",
     since | recipe},
    words::sampler, s.sampler...);
  f({"precision",
     "Precision of the arithmetic; auto: by the sizes in the scene; mixed: shapes are stored in 32 "
     "bits, paths are computed in 64",
     recipe | resolved},
    words::precision, s.precision...);
}

template <typename F, typename... S>
void stop_fields(F&& f, S&... s) {
  using namespace traits;
  f({"samples_per_pixel",
     "Samples per pixel: four times as many take four times as long and halve the noise", render,
     nullptr, "spp"},
    IntegerRange{1, limits::max_samples_per_pixel}, s.samples_per_pixel...);
  f({"target_error",
     "Stop when the RMSE of the picture (of the denoised picture, if it is denoised) is at most X, "
     "by the upper end of its 95 % interval, in linear radiance",
     accuracy | in_passes | recipe},
    ranges::target_error, s.target_error...);
  f({"target_denoised", nullptr, if_set}, OnOff{}, s.target_denoised...);
  f({"target_half_width",
     "Stop when 99 % of all pixel values (each channel) are known to within +-X, with 95 % "
     "confidence",
     accuracy | in_passes | recipe},
    ranges::target_error, s.target_half_width...);
  f({"time_limit",
     "The best picture that X seconds allow, writing included (a submitted job: from its first "
     "lease on; a film: for each frame); the report's `passes` repeat it",
     accuracy | in_passes | recipe},
    ranges::time_limit, s.time_limit...);
  f({"adaptive",
     "More samples where there is more noise (default: on with one of the limits above, off "
     "without)",
     accuracy | in_passes | recipe},
    OnOff{}, s.adaptive...);
  f({"passes", "Repeat a time-limited render: the list `passes` from its report",
     accuracy | special | in_passes},
    Passes{}, s.passes...);
}

template <typename F, typename... S>
void work_fields(F&& f, S&... s) {
  using namespace traits;
  f({"accelerator", "How shapes are searched; octree is a slow historical method, for comparison",
     speed | special | recipe | resolved},
    words::accelerator, s.accelerator...);
  f({"isa", "Instruction set to trace with; auto: the best that a machine has",
     speed | special | since},
    words::isa, s.isa...);
  f({"schedule", "Rule for the amount of work that a worker gets at a time (default: weighted)",
     speed | special},
    words::schedule, s.schedule...);
  f({"row_order",
     "Order in which workers get the rows; auto: interleaved with --schedule weighted, else "
     "sequential",
     speed | special | resolved},
    words::row_order, s.row_order...);
  f({"progressive", nullptr, if_set | no_report}, OnOff{}, s.progressive...);
  f({"replicates", nullptr, if_set | no_report}, OnOff{}, s.replicates...);
}

/// All settings, in the order of a command's help.
template <typename F, typename... S>
void settings_fields(F&& f, S&... s) {
  picture_fields(f, s...);
  stop_fields(f, s...);
  work_fields(f, s...);
}

}  // namespace parray::scene
