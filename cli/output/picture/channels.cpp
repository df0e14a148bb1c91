#include "cli/output/picture/channels.h"

#include <array>

#include "common/base/suggest.h"
#include "common/base/text.h"

namespace parray::picture {
namespace {

constexpr std::array<std::string_view, 7> aov_names{"depth", "normal",  "albedo",    "sphere",
                                                    "cost",  "samples", "half-width"};

Aov aov_from(std::string_view name) {
  return static_cast<Aov>(known_place("channel", name, aov_names));
}

}  // namespace

std::string_view name_of(Aov aov) { return aov_names.at(static_cast<std::size_t>(aov)); }

Aovs aovs_from(std::string_view names) {
  Aovs aovs;
  for (const std::string_view name : split_at(',', names)) aovs.insert(aov_from(name));
  return aovs;
}

std::string text_of(const Aovs& aovs) {
  std::string text;
  for (const Aov aov : aovs) text += (text.empty() ? "" : ",") + std::string(name_of(aov));
  return text;
}

}  // namespace parray::picture
