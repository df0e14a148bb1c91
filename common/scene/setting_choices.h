#pragma once

#include <cstdint>
#include <string_view>

#include "common/rooms.h"

namespace parray::scene {

/// The choices that settings.h names. They have a header of their own because they seldom change
/// and many sources use them.

enum class Precision : std::uint8_t { automatic = 0, f32 = 1, f64 = 2, mixed = 3 };  // wire values
enum class AcceleratorKind : std::uint8_t {                                          // wire values
  automatic = 0,
  linear = 1,
  bvh = 2,
  octree = 3  ///< never picked automatically
};
/// Instruction set of a kernel; automatic: the best that the machine has.
enum class Isa : std::uint8_t { automatic, scalar, avx2, avx512, neon };  // wire values: 0, 1, ...
enum class SchedulePolicy : std::uint8_t {                                // wire values
  static_split = 0,
  guided = 1,
  factoring = 2,
  weighted = 3
};
/// Where random numbers come from: see common/trace/integrator/random.h.
enum class Sampler : std::uint8_t { independent = 0, sobol = 1 };  // wire values
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

/// The value of a name that `name_of` gives. Throws InputError that lists the known names.
Precision precision_from(std::string_view name);
AcceleratorKind accelerator_from(std::string_view name);
Isa isa_from(std::string_view name);
Sampler sampler_from(std::string_view name);
SchedulePolicy schedule_from(std::string_view name);
RowOrder row_order_from(std::string_view name);

}  // namespace parray::scene
