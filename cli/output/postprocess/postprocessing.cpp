#include "cli/output/postprocess/postprocessing.h"

#include <variant>

#include "cli/output/picture/transparency.h"

namespace parray::postprocess {
namespace {

template <typename Value>
std::span<const Value> values_in(const ShownPicture& picture, const std::string& name) {
  for (const Channels* const channels : {picture.written, picture.traced}) {
    if (channels == nullptr) continue;
    for (const Channel& channel : *channels) {
      const auto* const values = std::get_if<std::vector<Value>>(&channel.values);
      if (channel.name == name && values != nullptr) return *values;
    }
  }
  return {};
}

}  // namespace

std::span<const float> ShownPicture::floats(const std::string& name) const {
  return values_in<float>(*this, name);
}

std::span<const std::uint32_t> ShownPicture::wholes(const std::string& name) const {
  return values_in<std::uint32_t>(*this, name);
}

Aovs needs_of(const PostprocessSteps& finishing) {
  Aovs needs;
  for (const PostprocessStep& step : finishing) needs.insert(step.needs.begin(), step.needs.end());
  return needs;
}

std::string names_of(const PostprocessSteps& finishing) {
  std::string names;
  for (const PostprocessStep& step : finishing) names += (names.empty() ? "" : ", ") + step.name;
  return names;
}

ShownPicture finished_picture(const Picture& picture, const PostprocessSteps& finishing) {
  const std::span<const float> alpha = alpha_of(picture.channels);
  ShownPicture shown{
      picture.image, {alpha.begin(), alpha.end()}, &picture.channels, &picture.traced};
  for (const PostprocessStep& step : finishing) step.apply(shown);
  return shown;
}

}  // namespace parray::postprocess
