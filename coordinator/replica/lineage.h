#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "coordinator/replica/ask.h"
#include "coordinator/store/store.h"

namespace parray {

/// What a store is in a farm whose state is kept twice.
enum class Part : std::uint8_t {
  primary,  ///< serves; acknowledges nothing that its standby lacks
  standby,  ///< a copy
  alone,    ///< serves by itself: its primary, or its standby, is gone
};

/// Whose state this is. Kept as a note; where there is none, it has never been replicated.
struct Lineage {
  std::uint64_t history = 0;
  std::uint64_t generation = 0;
  Part part = Part::alone;
};

/// The note's name; no copy carries it.
inline constexpr const char* lineage_note = "replica";

/// Throws RunError when the note is none.
std::optional<Lineage> lineage_of(Store& store);
void put_lineage(Store& store, const Lineage& lineage);

/// What the store's mark says: the position of all that is in it. Nothing: it says none (something
/// was kept that no standby was sent, say), or that of another generation.
std::optional<Position> position_of(Store& store, const Lineage& lineage);
void put_position(Store& store, const Position& position);

/// Makes a store that was replicated, or was a copy, serve by itself, as the next generation:
/// nobody may take it for what it was. Commits. Throws InputError where it is a copy that is not
/// whole. Returns the generation; 0: it has never been replicated, and nothing happens.
std::uint64_t serve_alone(Store& store);

}  // namespace parray
