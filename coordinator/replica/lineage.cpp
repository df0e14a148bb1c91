#include "coordinator/replica/lineage.h"

#include <sstream>

namespace parray {

std::optional<Lineage> lineage_of(Store& store) {
  const std::string text = store.note(lineage_note);
  if (text.empty()) {
    return std::nullopt;
  }
  std::istringstream in(text);
  Lineage lineage;
  unsigned part = 0;
  in >> lineage.history >> lineage.generation >> part;
  if (!in || lineage.history == 0 || part > static_cast<unsigned>(Part::alone)) {
    throw RunError("the state's note '" + std::string(lineage_note) + "' is damaged");
  }
  lineage.part = static_cast<Part>(part);
  return lineage;
}

void put_lineage(Store& store, const Lineage& lineage) {
  store.put_note(lineage_note, std::to_string(lineage.history) + " " +
                                   std::to_string(lineage.generation) + " " +
                                   std::to_string(static_cast<unsigned>(lineage.part)));
}

std::optional<Position> position_of(Store& store, const Lineage& lineage) {
  std::istringstream in(store.mark());
  Position position{lineage.history};
  in >> position.generation >> position.sequence;
  return in && position.generation == lineage.generation ? std::optional(position) : std::nullopt;
}

void put_position(Store& store, const Position& position) {
  store.put_mark(std::to_string(position.generation) + " " + std::to_string(position.sequence));
}

std::uint64_t serve_alone(Store& store) {
  std::optional<Lineage> lineage = lineage_of(store);
  if (!lineage) {
    return 0;
  }
  if (lineage->part == Part::standby && !position_of(store, *lineage)) {
    throw InputError(
        "--state: holds a copy that is not whole: start it with --standby, and its primary fills "
        "it up");
  }
  ++lineage->generation;
  lineage->part = Part::alone;
  put_lineage(store, *lineage);
  store.commit();
  return lineage->generation;
}

}  // namespace parray
