#include "cli/output/picture/channels.h"

#include <algorithm>
#include <array>

#include "common/base/error.h"
#include "common/base/printable.h"
#include "common/base/suggest.h"

namespace parray::picture {
namespace {

constexpr std::array<std::string_view, 7> aov_names{"depth", "normal",  "albedo",    "sphere",
                                                    "cost",  "samples", "half-width"};

Aov aov_from(std::string_view name) {
  const auto* const found = std::find(aov_names.begin(), aov_names.end(), name);
  if (found == aov_names.end()) {
    throw InputError("unknown channel '" + printable(name) +
                     "': " + remedy_for_name(name, aov_names));
  }
  return static_cast<Aov>(found - aov_names.begin());
}

}  // namespace

std::string_view name_of(Aov aov) { return aov_names.at(static_cast<std::size_t>(aov)); }

Aovs aovs_from(std::string_view names) {
  Aovs aovs;
  for (;;) {
    const std::size_t comma = names.find(',');
    aovs.insert(aov_from(names.substr(0, comma)));
    if (comma == std::string_view::npos) return aovs;
    names.remove_prefix(comma + 1);
  }
}

std::string text_of(const Aovs& aovs) {
  std::string text;
  for (const Aov aov : aovs) {
    text += (text.empty() ? "" : ",") + std::string(name_of(aov));
  }
  return text;
}

}  // namespace parray::picture
