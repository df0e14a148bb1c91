#include "cli/input/color/legend.h"

#include <algorithm>
#include <nlohmann/json.hpp>
#include <span>
#include <utility>

#include "cli/input/particles/json_types.h"

namespace parray::input {
namespace {

using nlohmann::ordered_json;

ordered_json json_of(const Legend& legend) {
  ordered_json out = {{"title", legend.title}};
  if (!legend.unit.empty()) out["unit"] = legend.unit;
  if (!legend.stops.empty()) {
    out["low"] = legend.low;
    out["high"] = legend.high;
    if (legend.log) out["log"] = true;
    out["stops"] = legend.stops;
  }
  const std::size_t listed = std::min(legend.entries.size(), most_listed_entries);
  for (const LegendEntry& entry : std::span(legend.entries).first(listed)) {
    ordered_json item = {{"name", entry.name}};
    if (entry.arrow) {
      item["arrow"] = true;
    } else {
      item["color"] = entry.color;
      item["count"] = entry.count;
    }
    out["entries"].push_back(std::move(item));
  }
  if (legend.entries.size() > listed) out["left_out"] = legend.entries.size() - listed;
  return out;
}

bool alike(const Legend& a, const Legend& b) {
  return a.title == b.title && a.unit == b.unit && a.low == b.low && a.high == b.high &&
         a.log == b.log && a.stops == b.stops;
}

void add_entry(std::vector<LegendEntry>& entries, LegendEntry more) {
  const auto same = std::ranges::find_if(entries, [&](const LegendEntry& entry) {
    return entry.name == more.name && entry.color == more.color;
  });
  if (same == entries.end()) {
    entries.push_back(std::move(more));
  } else {
    same->count += more.count;
  }
}

}  // namespace

void add_legend(std::vector<Legend>& legends, Legend more) {
  if (more.empty()) return;
  const auto there =
      std::ranges::find_if(legends, [&](const Legend& legend) { return alike(legend, more); });
  if (there == legends.end()) {
    legends.push_back(std::move(more));
    return;
  }
  for (LegendEntry& entry : more.entries) add_entry(there->entries, std::move(entry));
}

std::string legends_text(const std::vector<Legend>& legends) {
  ordered_json list = ordered_json::array();
  for (const Legend& legend : legends) list.push_back(json_of(legend));
  return list.dump(-1, ' ', false, ordered_json::error_handler_t::replace);
}

}  // namespace parray::input
