#include "common/process/description.h"

#include <algorithm>

#include "common/base/text.h"

namespace parray::process {
namespace {

std::vector<std::string> headings_of(const auto& entries) {
  std::vector<std::string> headings;
  for (const auto& entry : entries) {
    if (std::ranges::find(headings, entry.heading) == headings.end()) {
      headings.push_back(entry.heading);
    }
  }
  return headings;
}

}  // namespace

std::string OptionText::shown() const {
  return joined(names, ", ") + (names.empty() || value.empty() ? "" : " ") + value;
}

std::string CommandText::usage(bool has_commands) const {
  std::string text = launcher + name + (has_commands ? " COMMAND" : "");
  for (const OptionText& option : options) {
    if (!option.is_argument()) continue;
    const std::string shown = option.value + (option.repeats ? "..." : "");
    text += option.required ? " " + shown : " [" + shown + "]";
  }
  for (const OptionText& option : options) {
    if (!option.is_argument() && option.required) {
      text += " " + option.names.front() + " " + option.value;
    }
  }
  return text + (has_commands ? " [ARGUMENT...]" : " [OPTION...]");
}

std::string CommandText::page() const {
  std::string page = name;
  std::ranges::replace(page, ' ', '-');
  return page;
}

std::vector<std::string> CommandText::headings() const {
  std::vector<OptionText> named(options.begin(), options.end());
  std::erase_if(named, [](const OptionText& option) { return option.is_argument(); });
  return headings_of(named);
}

std::vector<std::string> ProgramText::headings() const { return headings_of(commands); }

}  // namespace parray::process
