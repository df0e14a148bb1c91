#include "cli/commands/view_options.h"

#include "cli/commands/options.h"

namespace parray::commands {

void ViewOptions::add_to(Command& command) {
  command
      .on_off("--transparent", transparent_,
              "Leave the background out: a picture with alpha, the share of a pixel's camera rays "
              "that meet something (default: as the scene says, else off)")
      .group(output_group);
  command.renamed("--opaque", "--transparent off");
}

bool ViewOptions::transparent(bool of_scene) const {
  return transparent_.value_or(followed_.value_or(of_scene));
}

}  // namespace parray::commands
