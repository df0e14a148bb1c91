#pragma once

#include <cstdint>
#include <string_view>

#include "common/rooms.h"

namespace parray::scene {

/// The choices that settings.h names. They have a header of their own because they seldom change
/// and many sources use them. `automatic` stands for a choice that resolve_settings() makes, except
/// for Isa. "Wire values" are numbers that messages or files may contain: do not change them.

/// Precision of tracing. f32: single; f64: double; mixed: paths in double, shapes stored in
/// single.
enum class Precision : std::uint8_t { automatic = 0, f32 = 1, f64 = 2, mixed = 3 };  // wire values
/// How a ray finds the next sphere. linear: tests every sphere; bvh, octree: trees of boxes. With
/// linear and bvh, capsules have a tree of their own. With octree, a ray tests every capsule.
enum class AcceleratorKind : std::uint8_t {  // wire values
  automatic = 0,
  linear = 1,
  bvh = 2,
  octree = 3  ///< never picked automatically
};
/// Instruction set of a kernel. automatic: every machine takes the best one that it has.
enum class Isa : std::uint8_t { automatic, scalar, avx2, avx512, neon };  // wire values: 0, 1, ...
/// Rule for the size of a lease: see chunk_units().
enum class SchedulePolicy : std::uint8_t {  // wire values
  static_split = 0,
  guided = 1,
  factoring = 2,
  weighted = 3
};
/// Where random numbers come from: see common/trace/integrator/random.h.
enum class Sampler : std::uint8_t { independent = 0, sobol = 1 };  // wire values
/// Order in which rows are leased: see make_row_order().
enum class RowOrder : std::uint8_t {
  automatic = 0,
  sequential = 1,
  interleaved = 2
};  // wire values

/// Names as they stand in options, reports and messages.
std::string_view name_of(Precision);
std::string_view name_of(AcceleratorKind);
std::string_view name_of(Isa);
std::string_view name_of(Sampler);
std::string_view name_of(SchedulePolicy);
std::string_view name_of(RowOrder);

/// Return the value of a name that `name_of` gives. Throw InputError, which lists the known names,
/// for any other name.
Precision precision_from(std::string_view name);
AcceleratorKind accelerator_from(std::string_view name);
Isa isa_from(std::string_view name);
Sampler sampler_from(std::string_view name);
SchedulePolicy schedule_from(std::string_view name);
RowOrder row_order_from(std::string_view name);

}  // namespace parray::scene
