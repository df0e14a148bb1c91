#include "coordinator/store/replication_state.h"

#include <sstream>

#include "common/base/bytes.h"

namespace parray::store {

std::optional<ReplicationState> replication_state_of(Store& store) {
  return replication_state_from_text(store.note(replication_note));
}

std::optional<ReplicationState> replication_state_from_text(const std::string& text) {
  if (text.empty()) return std::nullopt;
  std::istringstream in(text);
  ReplicationState replication;
  unsigned role = 0;
  in >> replication.history >> replication.generation >> role >> replication.copy_begin >>
      replication.copy_end;
  if (!in || replication.history == 0 || role > static_cast<unsigned>(ReplicaRole::fenced)) {
    throw RunError("the state's note '" + std::string(replication_note) +
                   "' is damaged: serve from a backup, or from the state of the other coordinator");
  }
  replication.role = static_cast<ReplicaRole>(role);
  for (EarlierGeneration earlier; in >> earlier.generation >> earlier.sequence;) {
    replication.earlier.push_back(earlier);
  }
  return replication;
}

void put_replication_state(Store& store, const ReplicationState& replication) {
  std::ostringstream out;
  out << replication.history << ' ' << replication.generation << ' '
      << static_cast<unsigned>(replication.role) << ' ' << replication.copy_begin << ' '
      << replication.copy_end;
  for (const EarlierGeneration& earlier : replication.earlier) {
    out << ' ' << earlier.generation << ' ' << earlier.sequence;
  }
  store.put_note(replication_note, out.str());
}

void begin_generation(Store& store, ReplicationState& replication, ReplicaRole role) {
  EarlierGeneration reached;
  std::istringstream in(store.reached_mark());
  if (in >> reached.generation >> reached.sequence &&
      reached.generation == replication.generation) {
    constexpr std::size_t most = 32;
    replication.earlier.push_back(reached);
    if (replication.earlier.size() > most) replication.earlier.erase(replication.earlier.begin());
  }
  ++replication.generation;
  replication.role = role;
  replication.copy_begin = replication.copy_end = 0;
  put_replication_state(store, replication);
}

std::string encode_generations(const ReplicationState& replication, const Position& position) {
  ByteWriter out;
  for (const EarlierGeneration& earlier : replication.earlier) {
    out.numbers(earlier.generation, earlier.sequence);
  }
  out.numbers(position.generation, position.sequence);
  return out.take();
}

std::vector<EarlierGeneration> decode_generations(std::string_view bytes) {
  std::vector<EarlierGeneration> earlier;
  constexpr std::size_t pair_bytes = 16;
  for (ByteReader in(bytes); in.left() >= pair_bytes;) {
    EarlierGeneration& one = earlier.emplace_back();
    in.numbers(one.generation, one.sequence);
  }
  return earlier;
}

void note_fence(Store& store) {
  ReplicationState replication = replication_state_of(store).value_or(ReplicationState{});
  replication.role = ReplicaRole::fenced;
  put_replication_state(store, replication);
  store.commit();
}

void check_fence(Store& store, bool serve_fenced, std::uint64_t history) {
  std::optional<ReplicationState> replication = replication_state_of(store);
  if (!replication || replication->role != ReplicaRole::fenced) return;
  if (!serve_fenced) {
    throw InputError(
        "--state: this state is out of date, because the standby of this coordinator has taken "
        "over: to make this the new standby, start it with --standby, and restart the other "
        "coordinator with --replicate-to. If the other coordinator and its state are lost, use "
        "--serve-fenced to serve this older state");
  }
  put_replication_state(store, {history, 1, ReplicaRole::single});
  store.commit();
}

std::optional<Position> position_of(Store& store, const ReplicationState& replication) {
  std::istringstream in(store.mark());
  Position position{replication.history};
  in >> position.generation >> position.sequence;
  return in && position.generation == replication.generation ? std::optional(position)
                                                             : std::nullopt;
}

static std::string text_of(const Position& position) {
  return std::to_string(position.generation) + " " + std::to_string(position.sequence);
}

void put_position(Store& store, const Position& position) { store.put_mark(text_of(position)); }

void put_reached_position(Store& store, const Position& position) {
  store.put_reached_mark(text_of(position));
}

bool is_whole(Store& store, const ReplicationState& replication) {
  // A repaired state or a backup has no mark.
  return replication.role != ReplicaRole::standby || replication.copy_end != 0 ||
         position_of(store, replication);
}

std::uint64_t serve_alone(Store& store) {
  std::optional<ReplicationState> replication = replication_state_of(store);
  if (!replication) return 0;
  if (!is_whole(store, *replication)) {
    throw InputError(
        "--state: this state is an incomplete copy: start this coordinator with --standby, so that "
        "its primary completes the copy");
  }
  begin_generation(store, *replication, ReplicaRole::single);
  store.commit();
  return replication->generation;
}

}  // namespace parray::store
