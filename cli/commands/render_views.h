#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "cli/commands/options.h"
#include "cli/input/view/view.h"

/// `parray render --views`: a file of particles from several sides, in one picture.
namespace parray::commands {

/// What is asked for; refers to what the command line has filled.
struct ViewsRequest {
  const std::string& scene;
  const std::vector<View>& views;
  const RenderOptions& render;
  const OutputOptions& output;
  const Following& following;
  std::uint32_t threads;
};

/// The value of --views: names with commas between, at most 16, none twice. Throws InputError.
std::vector<View> views_from(const std::string& text);

/// Renders one view after the other on this machine, finishes each and writes them as one PNG
/// picture (cli/output/postprocess/sheet.h), with a report of each. Returns the program's exit
/// status: 0, or 1 if samples were not finite. Throws InputError where something asked for is one
/// picture's.
int render_views(const ViewsRequest& request);

}  // namespace parray::commands
