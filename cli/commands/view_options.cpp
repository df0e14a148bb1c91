#include "cli/commands/view_options.h"

#include "cli/commands/options.h"
#include "common/base/error.h"

namespace parray {

void ViewOptions::add_to(Command& command) {
  command
      .flag("--transparent", transparent_,
            "Leave the background out: a picture with alpha, the share of a pixel's camera rays "
            "that meet something")
      .group(output_group);
  command.flag("--opaque", opaque_, "Leave it in, though the scene asks for a transparent one")
      .group(output_group);
}

bool ViewOptions::transparent(bool of_scene) const {
  if (transparent_ && opaque_) {
    throw InputError("--transparent and --opaque: give one of them");
  }
  return transparent_ || (followed_.value_or(of_scene) && !opaque_);
}

}  // namespace parray
