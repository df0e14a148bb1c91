#include "proto/control_frame.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "common/base/printable.h"
#include "common/base/sha256.h"
#include "common/base/text.h"
#include "proto/settings_json.h"

namespace parray::proto {
namespace {

using nlohmann::json;

constexpr std::size_t max_control_bytes = std::size_t{1} << 20;
constexpr std::size_t max_nesting = 8;
constexpr std::size_t max_held_leases = 64;

/// Builds a document during parsing if it is at most max_nesting deep. The library's own builder
/// accepts any depth, and its binary reader recurses once per level. So hostile bytes would
/// overflow the stack.
class ShallowDocument : public nlohmann::json_sax<json> {
 public:
  json take() { return std::move(root_); }

  bool null() override { return put(nullptr); }
  bool boolean(bool value) override { return put(value); }
  bool number_integer(number_integer_t value) override { return put(value); }
  bool number_unsigned(number_unsigned_t value) override { return put(value); }
  bool number_float(number_float_t value, const string_t& /*text*/) override { return put(value); }
  bool string(string_t& value) override { return put(std::move(value)); }
  bool binary(binary_t& /*value*/) override { return false; }
  bool start_object(std::size_t /*size*/) override { return open(json::object()); }
  bool key(string_t& value) override {
    place_ = &(*open_[depth_ - 1])[std::move(value)];
    return true;
  }
  bool end_object() override { return close(); }
  bool start_array(std::size_t /*size*/) override { return open(json::array()); }
  bool end_array() override { return close(); }
  bool parse_error(std::size_t /*position*/, const std::string& /*token*/,
                   const nlohmann::detail::exception& /*error*/) override {
    return false;
  }

 private:
  /// Returns the place of the next value: that of the last key, or the end of a list.
  json& place() {
    const bool in_list = depth_ > 0 && open_[depth_ - 1]->is_array();
    return in_list ? open_[depth_ - 1]->emplace_back(nullptr) : *place_;
  }
  bool put(json value) {
    place() = std::move(value);
    return true;
  }
  bool open(json empty) {
    if (depth_ == max_nesting) return false;
    json& opened = place();
    opened = std::move(empty);
    open_[depth_++] = &opened;
    return true;
  }
  bool close() {
    --depth_;
    return true;
  }

  json root_;
  json* place_ = &root_;
  std::array<json*, max_nesting> open_{};  ///< the containers around the next value
  std::size_t depth_ = 0;
};

[[noreturn]] void malformed(const std::string& key, const char* problem) {
  throw ProtocolError("'" + key + "' " + problem);
}

std::uint64_t unsigned_in(const json& value, const std::string& key, std::uint64_t lowest,
                          std::uint64_t highest) {
  if (!value.is_number_unsigned()) malformed(key, "is not an unsigned integer");
  const auto number = value.get<std::uint64_t>();
  if (number < lowest || number > highest) malformed(key, "is out of its range");
  return number;
}

}  // namespace

ControlWriter::ControlWriter(std::string_view type) {
  map_["v"] = protocol_version;
  map_["type"] = type;
}

void ControlWriter::text(const char* key, std::string& value, std::size_t longest,
                         std::size_t /*shortest*/) {
  map_[key] = printable(value, longest);
}

void ControlWriter::lines(const char* key, std::vector<std::string>& value, std::size_t most,
                          std::size_t longest) {
  auto list = json::array();
  const std::size_t first = value.size() - std::min(value.size(), most);
  for (std::size_t i = first; i < value.size(); ++i) list.push_back(printable(value[i], longest));
  map_[key] = std::move(list);
}

/// Writes the range and the numbers that make up the grid.
void ControlWriter::batch(const char* key, CellBatch& value) {
  const GridShape& s = value.grid->shape();
  auto stages = json::array();
  for (const Stage& stage : s.stages) {
    const Lattice& l = stage.lattice;
    l.step == 1 ? stages.push_back({stage.begin, stage.end})
                : stages.push_back({stage.begin, stage.end, l.x, l.y, l.step});
  }
  json& map = map_[key];
  map["range"] = std::array{value.range.begin, value.range.end};
  map["size"] = std::array{s.width, s.height};
  map["row_order"] = name_of(s.row_order);
  map["cut"] = std::array{s.band_rows, s.cell_pixels, s.layer_samples, s.piece_cells};
  map["stages"] = std::move(stages);
}

void ControlWriter::epochs(const char* key,
                           std::vector<std::pair<std::uint64_t, std::uint64_t>>& value) {
  auto list = json::array();
  for (const auto& [job, epoch] : value) list.push_back(std::array{job, epoch});
  map_[key] = std::move(list);
}

void ControlWriter::settings(const char* key, Boxed<RenderSettings>& value) {
  map_[key] = settings_to_json(value);
}

std::string ControlWriter::frame() const {
  std::string bytes;
  json::to_msgpack(map_, bytes);
  return bytes;
}

ControlReader::ControlReader(std::string_view frame) {
  if (frame.size() > max_control_bytes) throw ProtocolError("control frame is larger than 1 MiB");
  ShallowDocument document;
  if (!json::sax_parse(frame, &document, json::input_format_t::msgpack)) {
    throw ProtocolError("control frame is not MessagePack, or is nested too deep");
  }
  map_ = document.take();
  if (!map_.is_object()) throw ProtocolError("control frame is not a map");
  text("type", type_, max_name);
  protocol_ = static_cast<std::uint32_t>(integer("v", 0, 0xFFFFFFFF));
}

std::optional<std::uint64_t> ControlReader::request() const {
  const auto found = map_.find("request");
  if (found == map_.end() || !found->is_number_unsigned()) return {};
  return found->get<std::uint64_t>();
}

const json& ControlReader::at(const char* key) const {
  const auto found = map_.find(key);
  if (found == map_.end()) malformed(key, "is missing");
  return *found;
}

std::uint64_t ControlReader::integer(const char* key, std::uint64_t lowest,
                                     std::uint64_t highest) const {
  return unsigned_in(at(key), key, lowest, highest);
}

void ControlReader::real(const char* key, double& value, double highest) const {
  const json& found = at(key);
  if (!found.is_number()) malformed(key, "is not a number");
  value = found.get<double>();
  if (!std::isfinite(value)) malformed(key, "is not finite");
  if (value < 0 || value > highest) malformed(key, "is out of its range");
}

void ControlReader::flag(const char* key, bool& value) const {
  const json& found = at(key);
  if (!found.is_boolean()) malformed(key, "is not a boolean");
  value = found.get<bool>();
}

/// Text from other processes must not act on a terminal or a log. It must also be valid UTF-8,
/// because it is written as JSON later.
static std::string text_in(const json& found, const char* key, std::size_t longest,
                           std::size_t shortest) {
  if (!found.is_string()) malformed(key, "is not a string");
  auto value = found.get<std::string>();
  if (value.size() < shortest || value.size() > longest || printable(value, longest) != value) {
    malformed(key, "is empty, too long or not printable");
  }
  return value;
}

void ControlReader::text(const char* key, std::string& value, std::size_t longest,
                         std::size_t shortest) const {
  value = text_in(at(key), key, longest, shortest);
}

void ControlReader::lines(const char* key, std::vector<std::string>& value, std::size_t most,
                          std::size_t longest) const {
  const json& list = at(key);
  if (!list.is_array() || list.size() > most) malformed(key, "is not a list, or too long");
  value.clear();
  for (const json& line : list) value.push_back(text_in(line, key, longest, 0));
}

void ControlReader::digest(const char* key, std::string& value) const {
  text(key, value, 64);
  if (!is_sha256_hex(value)) malformed(key, "is not a SHA-256 digest");
}

void ControlReader::batch(const char* key, CellBatch& value) const {
  const json& map = at(key);
  const auto list = [&](const char* name, std::size_t least, std::size_t most) -> const json& {
    const auto found = map.is_object() ? map.find(name) : map.end();
    if (!map.is_object() || found == map.end() || !found->is_array() || found->size() < least ||
        found->size() > most) {
      malformed(key, "does not describe cells");
    }
    return *found;
  };
  const auto number = [&](const json& from) {
    return static_cast<std::uint32_t>(unsigned_in(from, key, 0, 0xFFFFFFFF));
  };
  const json& range = list("range", 2, 2);
  const json& size = list("size", 2, 2);
  const json& cut = list("cut", 4, 4);
  GridShape s;
  s.width = number(size[0]);
  s.height = number(size[1]);
  s.band_rows = number(cut[0]);
  s.cell_pixels = number(cut[1]);
  s.layer_samples = number(cut[2]);
  s.piece_cells = number(cut[3]);
  s.stages.clear();
  for (const json& stage : list("stages", 1, 64)) {
    if (!stage.is_array() || (stage.size() != 2 && stage.size() != 5)) {
      malformed(key, "does not describe cells");
    }
    s.stages.emplace_back(number(stage[0]), number(stage[1]));
    if (stage.size() == 5) {
      s.stages.back().lattice = {number(stage[2]), number(stage[3]), number(stage[4])};
    }
  }
  try {
    s.row_order = row_order_from(map.value("row_order", std::string()));
    value.grid = std::make_shared<const CellGrid>(std::move(s));
  } catch (const std::exception& error) {
    malformed(key, error.what());
  }
  value.range = {unsigned_in(range[0], key, 0, UINT64_MAX),
                 unsigned_in(range[1], key, 0, value.grid->cells())};
  if (value.range.begin >= value.range.end) malformed(key, "is empty");
}

void ControlReader::epochs(const char* key,
                           std::vector<std::pair<std::uint64_t, std::uint64_t>>& value) const {
  const json& list = at(key);
  if (!list.is_array() || list.size() > max_held_leases) {
    malformed(key, "is not a list of at most 64");
  }
  value.clear();
  for (const json& pair : list) {
    if (!pair.is_array() || pair.size() != 2) malformed(key, "does not hold pairs");
    value.emplace_back(unsigned_in(pair[0], key, 0, UINT64_MAX),
                       unsigned_in(pair[1], key, 0, UINT64_MAX));
  }
}

void ControlReader::numbers(const char* key, std::vector<std::uint64_t>& value,
                            std::size_t most) const {
  const json& list = at(key);
  if (!list.is_array() || list.empty() || list.size() > most) {
    malformed(key, ("is not a list of 1 to " + std::to_string(most)).c_str());
  }
  value.clear();
  for (const json& number : list) value.push_back(unsigned_in(number, key, 0, UINT64_MAX));
}

void ControlReader::settings(const char* key, Boxed<RenderSettings>& value) const {
  value = settings_from_json(at(key));
}

/// Returns content that is passed on unchanged, if it is `right` and can be written as JSON.
static const json& passed_on(const json& value, const char* key, bool right, const char* problem) {
  if (!right) malformed(key, problem);
  try {
    (void)value.dump();
  } catch (const json::exception&) {
    malformed(key, "has a text that is not UTF-8");
  }
  return value;
}

void ControlReader::object(const char* key, json& value) const {
  value = passed_on(at(key), key, at(key).is_object(), "is not a map");
}

void ControlReader::list(const char* key, json& value) const {
  value = passed_on(at(key), key, at(key).is_array(), "is not a list");
}

std::size_t ControlReader::index_of(const char* key, Names names) const {
  std::string name;
  text(key, name, max_name);
  const auto place = place_in(names, name);
  if (!place) malformed(key, "is an unknown word");
  return *place;
}

}  // namespace parray::proto
