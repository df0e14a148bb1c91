#include "coordinator/store/lineage.h"

#include <sstream>

#include "common/base/bytes.h"

namespace parray::store {

std::optional<Lineage> lineage_of(Store& store) {
  return lineage_from_text(store.note(lineage_note));
}

std::optional<Lineage> lineage_from_text(const std::string& text) {
  if (text.empty()) {
    return std::nullopt;
  }
  std::istringstream in(text);
  Lineage lineage;
  unsigned part = 0;
  in >> lineage.history >> lineage.generation >> part;
  if (!in || lineage.history == 0 || part > static_cast<unsigned>(Part::fenced)) {
    throw RunError("the state's note '" + std::string(lineage_note) + "' is damaged");
  }
  lineage.part = static_cast<Part>(part);
  in >> lineage.copy_begin >> lineage.copy_end;  // earlier versions end before
  for (LeftGeneration left; in >> left.generation >> left.sequence;) {
    lineage.left.push_back(left);
  }
  return lineage;
}

void put_lineage(Store& store, const Lineage& lineage) {
  std::ostringstream out;
  out << lineage.history << ' ' << lineage.generation << ' ' << static_cast<unsigned>(lineage.part)
      << ' ' << lineage.copy_begin << ' ' << lineage.copy_end;
  for (const LeftGeneration& left : lineage.left) {
    out << ' ' << left.generation << ' ' << left.sequence;
  }
  store.put_note(lineage_note, out.str());
}

void begin_generation(Store& store, Lineage& lineage, Part part) {
  LeftGeneration reached;
  std::istringstream in(store.reached_mark());
  if (in >> reached.generation >> reached.sequence && reached.generation == lineage.generation) {
    constexpr std::size_t most = 32;
    lineage.left.push_back(reached);
    if (lineage.left.size() > most) {
      lineage.left.erase(lineage.left.begin());
    }
  }
  ++lineage.generation;
  lineage.part = part;
  lineage.copy_begin = lineage.copy_end = 0;
  put_lineage(store, lineage);
}

std::string encode_left(const Lineage& lineage, const Position& position) {
  ByteWriter out;
  for (const LeftGeneration& left : lineage.left) {
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
  Lineage lineage = lineage_of(store).value_or(Lineage{});
  lineage.part = Part::fenced;
  put_lineage(store, lineage);
  store.commit();
}

void check_fence(Store& store, bool serve_fenced, std::uint64_t history) {
  std::optional<Lineage> lineage = lineage_of(store);
  if (!lineage || lineage->part != Part::fenced) {
    return;
  }
  if (!serve_fenced) {
    throw InputError(
        "--state: a standby has taken over from this state and serves as a later generation: start "
        "it with --standby, or say --serve-fenced to serve it as a farm of its own");
  }
  put_lineage(store, {history, 1, Part::alone});
  store.commit();
}

std::optional<Position> position_of(Store& store, const Lineage& lineage) {
  std::istringstream in(store.mark());
  Position position{lineage.history};
  in >> position.generation >> position.sequence;
  return in && position.generation == lineage.generation ? std::optional(position) : std::nullopt;
}

static std::string text_of(const Position& position) {
  return std::to_string(position.generation) + " " + std::to_string(position.sequence);
}

void put_position(Store& store, const Position& position) { store.put_mark(text_of(position)); }

void put_reached_position(Store& store, const Position& position) {
  store.put_reached_mark(text_of(position));
}

bool is_whole(Store& store, const Lineage& lineage) {
  // A repair, or a backup, leaves no mark.
  return lineage.part != Part::standby || lineage.copy_end != 0 || position_of(store, lineage);
}

std::uint64_t serve_alone(Store& store) {
  std::optional<Lineage> lineage = lineage_of(store);
  if (!lineage) {
    return 0;
  }
  if (!is_whole(store, *lineage)) {
    throw InputError(
        "--state: holds a copy that is not whole: start it with --standby, and its primary fills "
        "it up");
  }
  begin_generation(store, *lineage, Part::alone);
  store.commit();
  return lineage->generation;
}

}  // namespace parray::store
