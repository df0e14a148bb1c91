#include "proto/settings_json.h"

#include <algorithm>
#include <limits>
#include <string>

#include "common/base/error.h"
#include "proto/messages.h"

namespace parray::proto {
namespace {

using nlohmann::json;

template <typename T>
T number(const json& map, const char* key) {
  return static_cast<T>(natural_in(map, key, std::numeric_limits<T>::max()));
}

std::string word(const json& map, const char* key) {
  const auto found = map.find(key);
  if (found == map.end() || !found->is_string()) {
    throw ProtocolError(std::string("settings: '") + key + "' is missing or no string");
  }
  return found->get<std::string>();
}

}  // namespace

std::uint64_t natural_in(const json& map, const char* key, std::uint64_t most) {
  const auto found = map.find(key);
  if (found == map.end() || !found->is_number_unsigned()) {
    throw ProtocolError(std::string("'") + key + "' is missing or no unsigned integer");
  }
  const auto value = found->get<std::uint64_t>();
  if (value > most) {
    throw ProtocolError(std::string("'") + key + "' is out of its range");
  }
  return value;
}

std::vector<std::uint64_t> naturals_in(const json& map, const char* key) {
  const json list = map.value(key, json::array());
  const auto is_natural = [](const json& value) { return value.is_number_unsigned(); };
  if (!list.is_array() || !std::all_of(list.begin(), list.end(), is_natural)) {
    throw ProtocolError(std::string("'") + key + "' is no list of unsigned integers");
  }
  return list.get<std::vector<std::uint64_t>>();
}

json settings_to_json(const RenderSettings& s) {
  json map;
  map["width"] = s.width;
  map["height"] = s.height;
  map["samples_per_pixel"] = s.samples_per_pixel;
  map["max_depth"] = s.max_depth;
  map["seed"] = s.seed;
  map["sampler"] = name_of(s.sampler);
  map["precision"] = name_of(s.precision);
  map["accelerator"] = name_of(s.accelerator);
  map["isa"] = name_of(s.isa);
  map["schedule"] = name_of(s.schedule);
  map["row_order"] = name_of(s.row_order);
  if (s.in_passes()) {
    map["adaptive"] = s.adaptive;
    map["target_error"] = s.target_error;
    if (s.target_denoised) map["target_denoised"] = true;
    map["target_half_width"] = s.target_half_width;
    map["time_limit"] = s.time_limit;
    map["passes"] = s.passes;
  }
  if (s.progressive) {
    map["progressive"] = true;
  }
  if (s.replicates) {
    map["replicates"] = true;
  }
  return map;
}

RenderSettings settings_from_json(const json& map) {
  if (!map.is_object()) {
    throw ProtocolError("settings are not a map");
  }
  RenderSettings value;
  value.width = number<std::uint32_t>(map, "width");
  value.height = number<std::uint32_t>(map, "height");
  value.samples_per_pixel = number<std::uint32_t>(map, "samples_per_pixel");
  value.max_depth = number<std::uint32_t>(map, "max_depth");
  value.seed = number<std::uint64_t>(map, "seed");
  try {
    value.adaptive = map.value("adaptive", false);
    value.target_error = map.value("target_error", 0.0);
    value.target_denoised = map.value("target_denoised", false);
    value.target_half_width = map.value("target_half_width", 0.0);
    value.time_limit = map.value("time_limit", 0.0);
    value.progressive = map.value("progressive", false);
    value.replicates = map.value("replicates", false);
  } catch (const json::exception&) {
    throw ProtocolError("settings: a limit is of the wrong type");
  }
  value.passes = naturals_in(map, "passes");
  try {
    value.sampler =
        map.contains("sampler") ? sampler_from(word(map, "sampler")) : Sampler::independent;
    value.precision = precision_from(word(map, "precision"));
    value.accelerator = accelerator_from(word(map, "accelerator"));
    value.isa = map.contains("isa") ? isa_from(word(map, "isa")) : Isa::automatic;
    value.schedule = schedule_from(word(map, "schedule"));
    value.row_order = row_order_from(word(map, "row_order"));
    check_settings(value);
  } catch (const InputError& error) {
    throw ProtocolError(error.what());
  }
  if (value.precision == Precision::automatic || value.accelerator == AcceleratorKind::automatic ||
      value.row_order == RowOrder::automatic) {
    throw ProtocolError("settings leave something automatic");
  }
  return value;
}

}  // namespace parray::proto
