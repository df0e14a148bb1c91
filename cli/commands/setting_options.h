#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <functional>
#include <string>
#include <string_view>
#include <type_traits>
#include <vector>

#include "cli/commands/options.h"
#include "cli/input/scene_file/particle_fields.h"
#include "cli/input/scene_file/scene_fields.h"
#include "common/process/command_line.h"

/// Options from the descriptions of settings and of sections of a scene file.
namespace parray::commands {

/// Returns whether the option of a setting is rarely needed: only `help COMMAND --all` shows it.
inline bool rarely_needed(const Setting& setting) {
  constexpr std::array<std::string_view, 14> keys = {
      "max_depth", "sampler",   "precision", "target_half_width", "adaptive",
      "outline",   "depth_cue", "unit",      "time_stamp",        "cell",
      "text",      "font_size", "dpi",       "legend_title"};
  return setting.is(traits::special) || std::ranges::count(keys, setting.key) > 0;
}

/// Parses the text of a setting by its rule. Returns a value, or the index of a word in Words.
/// Throws InputError if the rule does not allow the text.
inline std::uint64_t value_of(IntegerRange range, const std::string& text) {
  return whole_number(text, range.least, range.most);
}
bool value_of(OnOff rule, const std::string& text);
std::vector<std::uint64_t> value_of(Passes rule, const std::string& text);
/// Replaces each pair of a backslash and an n by a line break.
std::string value_of(LabelText rule, const std::string& text);
inline double value_of(NumberRange range, const std::string& text) {
  return real_number(text, range);
}
inline std::size_t value_of(const Words& words, const std::string& text) {
  return index_in(words, text);
}
inline LineWidth value_of(LineWidthRange /*range*/, const std::string& text) {
  return line_width_from(text);
}
inline double value_of(ShareRange /*range*/, const std::string& text) {
  return depth_cue_from(text);
}
template <typename T>
T value_of(const TextRule<T>& rule, const std::string& text) {
  return rule.parse(text);
}
inline std::string value_of(FileName /*rule*/, const std::string& text) { return text; }
inline std::vector<std::string> value_of(HiddenClasses /*rule*/, const std::string& text) {
  return hide_from(text);
}

/// Describe the values of a rule, so that the help and shells offer them.
inline void describe_values(IntegerRange /*rule*/, Option& option) { option.type_name("N"); }
inline void describe_values(Passes /*rule*/, Option& option) { option.type_name("N,N..."); }
inline void describe_values(OnOff /*rule*/, Option& option) { option.words({"on", "off"}); }
inline void describe_values(const Words& words, Option& option) {
  option.words({words.names.begin(), words.names.end()});
}
inline void describe_values(FileName /*rule*/, Option& option) {
  option.forbid_empty().completes(Completes::files);
}
void describe_values(HiddenClasses rule, Option& option);
template <typename T>
void describe_values(const TextRule<T>& rule, Option& option) {
  if (!rule.words.empty()) option.words({rule.words.begin(), rule.words.end()});
}
void describe_values(const auto& /*any other rule*/, Option& option) { option.type_name("X"); }

/// Declares the option of a setting. If the user gives it, the option sets `value` and then calls
/// `note`. The option of a Flag sets `value` to true and does not call `note`. `value` must not
/// move while the command line is parsed.
template <typename Rule, typename T>
Option add_setting(
    Command& command, const Setting& setting, const Rule& rule, T& value,
    const std::function<void()>& note = [] {}) {
  if constexpr (std::is_same_v<Rule, Flag>) {
    return command.flag(option_of(setting), value, setting.help);
  } else {
    Option option = command.option(
        option_of(setting),
        [rule, &value, note](const std::string& text) {
          value = static_cast<T>(value_of(rule, text));
          note();
        },
        setting.help);
    describe_values(rule, option);
    return setting.value != nullptr ? option.type_name(setting.value) : option;
  }
}

}  // namespace parray::commands
