#include "coordinator/store/replication_state.h"

#include <sstream>

#include "common/base/bytes.h"

namespace parray::store {

std::optional<ReplicationState> replication_state_of(Store& store) {
  return replication_state_from_text(store.note(replication_note));
}

std::optional<ReplicationState> replication_state_from_text(const std::string& text) {
  if (text.empty()) {
    return std::nullopt;
  }
  std::istringstream in(text);
  ReplicationState replication;
  unsigned part = 0;
  in >> replication.history >> replication.generation >> part >> replication.copy_begin >>
      replication.copy_end;
  if (!in || replication.history == 0 || part > static_cast<unsigned>(ReplicaRole::fenced)) {
    throw RunError("the state's note '" + std::string(replication_note) + "' is damaged");
  }
  replication.part = static_cast<ReplicaRole>(part);
  for (LeftGeneration left; in >> left.generation >> left.sequence;) {
    replication.left.push_back(left);
  }
  return replication;
}

void put_replication_state(Store& store, const ReplicationState& replication) {
  std::ostringstream out;
  out << replication.history << ' ' << replication.generation << ' '
      << static_cast<unsigned>(replication.part) << ' ' << replication.copy_begin << ' '
      << replication.copy_end;
  for (const LeftGeneration& left : replication.left) {
    out << ' ' << left.generation << ' ' << left.sequence;
  }
  store.put_note(replication_note, out.str());
}

void begin_generation(Store& store, ReplicationState& replication, ReplicaRole part) {
  LeftGeneration reached;
  std::istringstream in(store.reached_mark());
  if (in >> reached.generation >> reached.sequence &&
      reached.generation == replication.generation) {
    constexpr std::size_t most = 32;
    replication.left.push_back(reached);
    if (replication.left.size() > most) {
      replication.left.erase(replication.left.begin());
    }
  }
  ++replication.generation;
  replication.part = part;
  replication.copy_begin = replication.copy_end = 0;
  put_replication_state(store, replication);
}

std::string encode_left(const ReplicationState& replication, const Position& position) {
  ByteWriter out;
  for (const LeftGeneration& left : replication.left) {
    out.put(left.generation);
    out.put(left.sequence);
  }
  out.put(position.generation);
  out.put(position.sequence);
  return out.take();
}

std::vector<LeftGeneration> decode_left(std::string_view bytes) {
  std::vector<LeftGeneration> left;
  constexpr std::size_t pair_bytes = 16;
  for (ByteReader in(bytes); in.left() >= pair_bytes;) {
    const auto generation = in.get<std::uint64_t>();
    left.push_back({generation, in.get<std::uint64_t>()});
  }
  return left;
}

void note_fence(Store& store) {
  ReplicationState replication = replication_state_of(store).value_or(ReplicationState{});
  replication.part = ReplicaRole::fenced;
  put_replication_state(store, replication);
  store.commit();
}

void check_fence(Store& store, bool serve_fenced, std::uint64_t history) {
  std::optional<ReplicationState> replication = replication_state_of(store);
  if (!replication || replication->part != ReplicaRole::fenced) {
    return;
  }
  if (!serve_fenced) {
    throw InputError(
        "--state: a standby has taken over from this state and serves as a later generation: start "
        "it with --standby, or say --serve-fenced to serve it as a farm of its own");
  }
  put_replication_state(store, {history, 1, ReplicaRole::alone});
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
  // A repair, or a backup, leaves no mark.
  return replication.part != ReplicaRole::standby || replication.copy_end != 0 ||
         position_of(store, replication);
}

std::uint64_t serve_alone(Store& store) {
  std::optional<ReplicationState> replication = replication_state_of(store);
  if (!replication) {
    return 0;
  }
  if (!is_whole(store, *replication)) {
    throw InputError(
        "--state: holds a copy that is not whole: start it with --standby, and its primary fills "
        "it up");
  }
  begin_generation(store, *replication, ReplicaRole::alone);
  store.commit();
  return replication->generation;
}

}  // namespace parray::store
