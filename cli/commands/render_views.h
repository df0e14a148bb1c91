#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "cli/commands/prepare.h"
#include "cli/input/view/view.h"

/// `parray render --views`: a file of particles from several sides, in one picture.
namespace parray::commands {

/// Parses the value of --views: different names, separated by commas, at most 16. Throws
/// InputError.
std::vector<View> views_from(const std::string& text);

/// Renders one view after the other in this process and writes them as one PNG picture
/// (cli/output/postprocess/sheet.h). The report contains a report of each view. `request`: of
/// RenderMode::sheet. Returns the exit status: 0, or 1 if samples were not finite. Throws
/// InputError.
int render_views(const RenderRequest& request, const std::vector<View>& views);

}  // namespace parray::commands
