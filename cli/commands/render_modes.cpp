#include "cli/commands/render_modes.h"

#include <algorithm>
#include <array>
#include <vector>

#include "common/base/error.h"

namespace parray::commands {
namespace {

struct Rules {
  const char* what;    ///< for messages
  const char* remedy;  ///< usual one
  std::vector<Feature> lacks;
};

/// By RenderMode.
const std::array<Rules, 8>& rules() {
  using enum Feature;
  static const std::array<Rules, 8> all = {{
      {"parray render", "", {}},
      {"parray-mpi", "", {denoised_target}},
      {"pictures of a farm", "", {denoised_target}},
      {"parray submit without a picture file",
       "add --wait -o IMAGE, or --transparent off",
       {denoised_target, transparency, postprocessing}},
      {"a sheet of views (--views)",
       "leave it out, or render the views one by one with --view",
       {preview, end_command, error_map, exr_file, like, view, standard_input}},
      {"a series of frames",
       "leave it out, or render the frames one by one",
       {denoising, denoised_target, transparency, labels, postprocessing, preview, like,
        traced_channels, standard_input}},
      {"pictures by HTTP", "leave it out", {denoised_target, transparency}},
      {"parray fetch, which has no scene",
       "leave it out, or use parray render, or parray submit --wait",
       {traced_channels}},
  }};
  return all;
}

const Rules& rules_of(RenderMode mode) { return rules()[static_cast<std::size_t>(mode)]; }

std::string remedy_of(RenderMode mode, Feature feature) {
  switch (feature) {
    case Feature::denoised_target:
      return "use parray render, or give --spp instead of --target-error";
    case Feature::exr_file:
      return "write a PNG file (.png), or an EXR file of each view with --view";
    case Feature::standard_input:
      return "standard input can be read once: save it as a file";
    default:
      return rules_of(mode).remedy;
  }
}

}  // namespace

bool can_have(RenderMode mode, Feature feature) {
  return std::ranges::count(rules_of(mode).lacks, feature) == 0;
}

void require(RenderMode mode, Feature feature, const std::string& name) {
  if (can_have(mode, feature)) return;
  throw InputError(name + ": not possible for " + rules_of(mode).what + ": " +
                   remedy_of(mode, feature));
}

}  // namespace parray::commands
