#pragma once

#include <optional>
#include <string>
#include <vector>

#include "cli/input/view/portrait.h"
#include "common/process/command_line.h"

namespace parray::commands {

/// view_names and view_axes, as known words of an option.
std::vector<std::string> view_words();

/// From where a file of particles is seen, and what is around it. Part of RenderOptions.
class PortraitOptions {
 public:
  /// They must stay where they are while the command line is parsed.
  void add_to(Command& command);
  /// Throws InputError that names those given: the scene `file` is not a file of particles.
  void check_unused(const std::string& file) const;
  [[nodiscard]] Viewing viewing() const;

  [[nodiscard]] bool has_view() const { return view_.has_value(); }
  void look_from(View view) { view_ = view; }
  /// The particles' cell is to be in the picture if `wanted`, which stays where it is, is true by
  /// then.
  void frame_cell(const bool& wanted) { whole_cell_ = &wanted; }

 private:
  std::optional<View> view_;
  std::optional<Style> style_;
  std::optional<Projection> projection_;
  const bool* whole_cell_ = nullptr;
};

}  // namespace parray::commands
