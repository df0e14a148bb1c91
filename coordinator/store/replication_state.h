#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "coordinator/store/store.h"

namespace parray::store {

/// Where a store stands. Of one history: a higher generation is a later primary's.
struct Position {
  std::uint64_t history = 0;  ///< random, of a farm's state since it was first replicated; not 0
  std::uint64_t generation = 0;
  std::uint64_t sequence = 0;  ///< batches that are committed
  friend bool operator==(const Position&, const Position&) = default;
};

/// What a store is in a farm whose state is kept twice.
enum class ReplicaRole : std::uint8_t {
  primary,  ///< serves; acknowledges nothing that its standby lacks
  standby,  ///< a copy
  alone,    ///< serves by itself: its primary, or its standby, is gone
  fenced,   ///< was a primary; its standby has taken over
};

/// An earlier generation of a primary, and how many of its batches the primary had when it left it.
struct LeftGeneration {
  std::uint64_t generation = 0;
  std::uint64_t sequence = 0;
};

/// Whose state this is. Kept as a note; where there is none, it has never been replicated.
struct ReplicationState {
  std::uint64_t history = 0;
  std::uint64_t generation = 0;
  ReplicaRole part = ReplicaRole::alone;
  /// Of a standby: the batches from `copy_begin`, exclusively, to `copy_end` made its full copy.
  /// They contain no more than what the primary had at `copy_begin`, and one batch under way.
  std::uint64_t copy_begin = 0;
  std::uint64_t copy_end = 0;
  std::vector<LeftGeneration> left{};  ///< the latest at the end; the oldest are forgotten
};

/// The note's name; no copy carries it.
inline constexpr const char* replication_note = "replica";

/// Begins another generation as `part`; notes how far the store has come in the one before.
void begin_generation(Store& store, ReplicationState& replication, ReplicaRole part);

/// The generations that a primary has left, and the one that it is in, as bytes of a `hello`.
std::string encode_left(const ReplicationState& replication, const Position& position);
/// Inverse. Bytes of a primary that sends none, or others, are an empty list.
std::vector<LeftGeneration> decode_left(std::string_view bytes);

/// Throws RunError when the note is none.
std::optional<ReplicationState> replication_state_of(Store& store);
/// The same of the note's text.
std::optional<ReplicationState> replication_state_from_text(const std::string& text);
void put_replication_state(Store& store, const ReplicationState& replication);

/// What the store's mark says: the position of all that is in it. Nothing: it says none (something
/// was kept that no standby was sent, say), or that of another generation.
std::optional<Position> position_of(Store& store, const ReplicationState& replication);
void put_position(Store& store, const Position& position);
/// Notes the furthest position whose changes the store contains completely. It may contain more.
void put_reached_position(Store& store, const Position& position);

/// Whether the store may serve: it is no standby's, or a full copy has come to its end.
bool is_whole(Store& store, const ReplicationState& replication);

/// Makes the store of a primary refuse to serve from now on: its standby has taken over. Commits.
void note_fence(Store& store);
/// Throws InputError when the store is that of a fenced primary, unless `serve_fenced`: then it
/// becomes the state of another farm, whose number is `history`. Commits.
void check_fence(Store& store, bool serve_fenced, std::uint64_t history);

/// Makes a store that was replicated, or was a copy, serve by itself, as the next generation:
/// nobody may take it for what it was. Commits. Throws InputError where it is a copy that is not
/// whole. Returns the generation; 0: it has never been replicated, and nothing happens.
std::uint64_t serve_alone(Store& store);

}  // namespace parray::store
