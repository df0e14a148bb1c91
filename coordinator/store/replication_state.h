#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "coordinator/store/store.h"

namespace parray::store {

/// The position of a store in the sequence of replicated batches. A takeover raises the generation.
struct Position {
  std::uint64_t history = 0;  ///< random number of the farm's replicated state; not 0
  std::uint64_t generation = 0;
  std::uint64_t sequence = 0;  ///< number of committed batches of this generation
  friend bool operator==(const Position&, const Position&) = default;
};

/// The role of a store whose state is or was kept twice. Stored by value: do not renumber.
enum class ReplicaRole : std::uint8_t {
  primary,  ///< serves and acknowledges only what its standby has committed
  standby,  ///< is a copy of a primary's state
  single,   ///< serves without a standby
  fenced,   ///< was a primary until its standby took over
};

/// An earlier generation of a primary, and how many batches of it the primary has committed.
struct EarlierGeneration {
  std::uint64_t generation = 0;
  std::uint64_t sequence = 0;
};

/// History, generation and role of a store: a note that stores get when they are first replicated.
struct ReplicationState {
  std::uint64_t history = 0;
  std::uint64_t generation = 0;
  ReplicaRole role = ReplicaRole::single;
  /// Sequence numbers, only for a standby: the batches after `copy_begin`, up to `copy_end`, made
  /// its full copy, the state of the primary at `copy_begin` plus at most one batch. `copy_end` is
  /// 0 during the copy.
  std::uint64_t copy_begin = 0;
  std::uint64_t copy_end = 0;
  std::vector<EarlierGeneration> earlier{};  ///< the latest 32, in ascending order
};

/// Name of the note. Full copies do not contain it.
inline constexpr const char* replication_note = "replica";

/// Begins the next generation as `role`, in `replication` and in the store's note. Records the
/// sequence reached in the previous generation. The caller commits.
void begin_generation(Store& store, ReplicationState& replication, ReplicaRole role);

/// Returns the primary's earlier generations and its current position, as bytes of a `hello`.
std::string encode_generations(const ReplicationState& replication, const Position& position);
/// Decodes the bytes of a `hello`. Ignores an incomplete pair at the end.
std::vector<EarlierGeneration> decode_generations(std::string_view bytes);

/// Reads the note of the store; nothing: it has none. Throws RunError if the note is damaged.
std::optional<ReplicationState> replication_state_of(Store& store);
/// Reads the text of the note; nothing: the text is empty. Throws RunError if it is damaged.
std::optional<ReplicationState> replication_state_from_text(const std::string& text);
void put_replication_state(Store& store, const ReplicationState& replication);

/// Returns the position that describes exactly the content of the store, from its mark. Nothing:
/// the mark is missing (a standby lacks the latest commit, for example) or of another generation.
std::optional<Position> position_of(Store& store, const ReplicationState& replication);
void put_position(Store& store, const Position& position);
/// Puts the latest position whose changes the store contains completely. The store may have more.
void put_reached_position(Store& store, const Position& position);

/// Returns whether the store may serve: false for a standby whose full copy is incomplete.
bool is_whole(Store& store, const ReplicationState& replication);

/// Marks the store of a primary as fenced, for check_fence(). Commits.
void note_fence(Store& store);
/// Throws InputError if the store is that of a fenced primary. With `serve_fenced`, the store
/// becomes the state of a new farm with the number `history` instead. Commits.
void check_fence(Store& store, bool serve_fenced, std::uint64_t history);

/// Begins the next generation of a store that is or was replicated, as one without a standby.
/// Commits. Returns the generation. Does nothing and returns 0 if the store was never replicated.
/// Throws InputError for an incomplete copy.
std::uint64_t serve_alone(Store& store);

}  // namespace parray::store
