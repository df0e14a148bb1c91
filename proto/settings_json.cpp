#include "proto/settings_json.h"

#include <algorithm>
#include <limits>
#include <string>
#include <type_traits>

#include "common/base/error.h"
#include "common/scene/settings_fields.h"
#include "proto/messages.h"

namespace parray::proto {
namespace {

using nlohmann::json;

/// Returns the settings for which `wanted(setting, value)` is true, with the names of words.
json map_of(const RenderSettings& settings, const auto& wanted) {
  json map;
  settings_fields(
      [&](const Setting& setting, const auto& /*rule*/, const auto& value) {
        if (!wanted(setting, value)) return;
        if constexpr (std::is_enum_v<std::decay_t<decltype(value)>>) {
          map[setting.key] = name_of(value);
        } else {
          map[setting.key] = value;
        }
      },
      settings);
  return map;
}

std::string word(const json& map, const char* key) {
  const auto found = map.find(key);
  if (found == map.end() || !found->is_string()) {
    throw ProtocolError(std::string("settings: '") + key + "' is missing or not a string");
  }
  return found->get<std::string>();
}

template <typename T>
T limit(const json& map, const char* key) {
  try {
    return map.value(key, T{});
  } catch (const json::exception&) {
    throw ProtocolError(std::string("settings: '") + key + "' has the wrong type");
  }
}

/// Reads a setting; a missing one means 0 where the description allows that.
template <typename Rule, typename T>
void read(const json& map, const Setting& setting, const Rule& rule, T& value) {
  constexpr unsigned may_miss = traits::since | traits::in_passes | traits::if_set;
  if (setting.is(may_miss) && !map.contains(setting.key)) {
    value = T{};
    // NOLINTNEXTLINE(bugprone-branch-clone): branches of other types look equal
  } else if constexpr (std::is_same_v<Rule, Words>) {
    value = static_cast<T>(index_in(rule, word(map, setting.key)));
  } else if constexpr (std::is_same_v<Rule, IntegerRange>) {
    value = static_cast<T>(natural_in(map, setting.key, std::numeric_limits<T>::max()));
  } else if constexpr (std::is_same_v<Rule, Passes>) {
    value = naturals_in(map, setting.key);
  } else {
    value = limit<T>(map, setting.key);
  }
}

}  // namespace

std::uint64_t natural_in(const json& map, const char* key, std::uint64_t most) {
  const auto found = map.find(key);
  if (found == map.end() || !found->is_number_unsigned()) {
    throw ProtocolError(std::string("'") + key + "' is missing or not an unsigned integer");
  }
  const auto value = found->get<std::uint64_t>();
  if (value > most) throw ProtocolError(std::string("'") + key + "' is out of its range");
  return value;
}

std::vector<std::uint64_t> naturals_in(const json& map, const char* key) {
  const json list = map.value(key, json::array());
  const auto is_natural = [](const json& value) { return value.is_number_unsigned(); };
  if (!list.is_array() || !std::all_of(list.begin(), list.end(), is_natural)) {
    throw ProtocolError(std::string("'") + key + "' is not a list of unsigned integers");
  }
  return list.get<std::vector<std::uint64_t>>();
}

json settings_to_json(const RenderSettings& settings) {
  return map_of(settings, [&](const Setting& setting, const auto& value) {
    if (setting.is(traits::if_set)) return value != std::decay_t<decltype(value)>{};
    return !setting.is(traits::in_passes) || settings.in_passes();
  });
}

json settings_in_report(const RenderSettings& settings) {
  return map_of(settings, [](const Setting& setting, const auto& /*value*/) {
    return !setting.is(traits::no_report);
  });
}

Boxed<RenderSettings> settings_from_json(const json& map) {
  if (!map.is_object()) throw ProtocolError("settings are not a map");
  RenderSettings settings;
  bool automatic = false;
  try {
    settings_fields(
        [&](const Setting& setting, const auto& rule, auto& value) {
          read(map, setting, rule, value);
          automatic |= setting.is(traits::resolved) && value == std::decay_t<decltype(value)>{};
        },
        settings);
    check_settings(settings);
  } catch (const InputError& error) {
    throw ProtocolError(error.what());
  }
  if (automatic) throw ProtocolError("settings: a value other than 'isa' is still 'auto'");
  return settings;
}

}  // namespace parray::proto
