#pragma once

#include <cstddef>
#include <span>
#include <string>
#include <string_view>

#include "common/scene/limits.h"

/// The parts that descriptions of settings are made of: see settings_fields.h.
namespace parray::scene {

/// The traits of a setting, besides its rule.
namespace traits {
enum : unsigned {
  image = 1U << 0,      ///< in section "image" of a scene file
  render = 1U << 1,     ///< in section "render" of a scene file
  accuracy = 1U << 2,   ///< its option is under the heading "Accuracy" of the help
  speed = 1U << 3,      ///< its option never changes the picture
  special = 1U << 4,    ///< its option is for experiments: only the full help shows it
  since = 1U << 5,      ///< earlier versions lack it in messages and records: 0 then
  in_passes = 1U << 6,  ///< only in messages of pictures in passes; missing means 0
  if_set = 1U << 7,     ///< missing in messages, records and sections if it is 0
  no_report = 1U << 8,  ///< a report does not repeat it
  recipe = 1U << 9,     ///< a recipe (settings in a picture file) has the report's value
  resolved = 1U << 10,  ///< a worker refuses `automatic`
  required = 1U << 11,  ///< a section must have it
};
}  // namespace traits

/// The name of a setting and its place in files, messages and options.
struct Setting {
  const char* key;              ///< key in files and messages
  const char* help = nullptr;   ///< help of its option; null: it has no option
  unsigned traits = 0;          ///< sum of the traits above
  const char* value = nullptr;  ///< placeholder of the value in the help; null: chosen by the rule
  const char* keyword = nullptr;  ///< name of its option if it differs from the key

  /// Returns whether the setting has at least one of these traits.
  [[nodiscard]] bool is(unsigned any) const { return (traits & any) != 0; }
};

/// Returns the name of a setting in Python and in the HTTP service: "max_depth".
std::string keyword_of(const Setting& setting);
/// Returns the name of a setting's option: "--max-depth".
std::string option_of(const Setting& setting);

// Rules: which values a setting may have. limits.h has further ones. For settings,
// NumberRange also allows 0, which means no limit.
struct OnOff {};   ///< a boolean
struct Passes {};  ///< a list of numbers of samples: StopSettings::passes

/// The words of an enumeration, in the order of its values.
struct Words {
  const char* what;  ///< name of the setting in messages
  std::span<const std::string_view> names;
};
/// Returns the index of a word. For any other word, throws InputError with the known words.
std::size_t index_in(const Words& words, std::string_view name);
/// Returns the word of an index; "unknown" for any other index.
std::string_view name_in(const Words& words, std::size_t index);

}  // namespace parray::scene
