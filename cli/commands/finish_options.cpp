#include "cli/commands/finish_options.h"

#include <array>
#include <string_view>

#include "cli/commands/options.h"
#include "common/base/error.h"
#include "common/base/printable.h"
#include "common/base/suggest.h"

namespace parray {
namespace {

/// A number, of which `what` says more; a word that is none gets the nearest known one.
double number_or_word(const std::string& text, NumberRange range, const std::string& what) {
  static constexpr std::array<std::string_view, 2> words{"on", "off"};
  try {
    return real_number(text, range);
  } catch (const InputError& error) {
    NearestWord nearest(text);
    for (const std::string_view word : words) nearest.offer(word);
    const bool wordlike = !nearest.best().empty() && text.find_first_of("0123456789") > text.size();
    throw InputError(wordlike ? "unknown word '" + printable(text) + "': did you mean '" +
                                    nearest.best() + "'?"
                              : error.what() + (": write on, off or " + what));
  }
}

LineWidth line_width_in(const std::string& text) {
  if (text == "on") return {LineWidth::Unit::automatic, 0};
  if (text == "off") return {};
  const bool points = text.ends_with("pt");
  const std::string number = points ? text.substr(0, text.size() - 2) : text;
  return {points ? LineWidth::Unit::points : LineWidth::Unit::pixels,
          number_or_word(number, ranges::line_width, "a width in pixels, or in points as 0.5pt")};
}

double depth_cue_in(const std::string& text) {
  if (text == "on") return usual_depth_cue;
  if (text == "off") return 0;
  return number_or_word(text, ranges::depth_cue, "a share");
}

}  // namespace

void FinishOptions::add_to(Command& command, const Option& image) {
  command
      .option(
          "--outline", [this](const std::string& text) { outline_ = line_width_in(text); },
          "Dark lines where spheres end before others that are farther away, so many pixels or, "
          "with --dpi, points (0.5pt) wide; on: a 450th of the picture's height")
      .type_name("on|off|WIDTH")
      .group(finish_group)
      .needs(image);
  command
      .option(
          "--depth-cue", [this](const std::string& text) { depth_cue_ = depth_cue_in(text); },
          "What is far fades into the background, the farthest by that share; on: 0.6")
      .type_name("on|off|SHARE")
      .group(finish_group)
      .needs(image);
}

Finish FinishOptions::over(Finish of_scene) const {
  of_scene.outline = outline_.value_or(of_scene.outline);
  of_scene.depth_cue = depth_cue_.value_or(of_scene.depth_cue);
  return of_scene;
}

std::string FinishOptions::first_given() const {
  if (outline_ && outline_->unit != LineWidth::Unit::none) return "--outline";
  return depth_cue_ && *depth_cue_ > 0 ? "--depth-cue" : "";
}

}  // namespace parray
