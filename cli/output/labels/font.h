#pragma once

#include <filesystem>
#include <memory>
#include <string>
#include <string_view>

#include "cli/output/labels/coverage.h"

namespace parray::labels {

/// DejaVu Sans, where Debian's fonts-dejavu-core puts it.
inline constexpr const char* label_font = "/usr/share/fonts/truetype/dejavu/DejaVuSans.ttf";

/// Text in one size, of one font, drawn by FreeType: unhinted and placed to a 64th of a pixel, so
/// that widths are those of the font at any size. Letters stand one after the other from left to
/// right, with the font's kerning; scripts that need more are set as their letters. Text is UTF-8.
class Font {
 public:
  /// `size`: pixels an em, >= 1. Throws RunError, which names the package, when the file is not
  /// there or is no font.
  explicit Font(double size, const std::filesystem::path& file = label_font);
  ~Font();
  Font(const Font&) = delete;
  Font& operator=(const Font&) = delete;

  [[nodiscard]] double size() const { return size_; }
  /// From the baseline up to the top of capitals.
  [[nodiscard]] double cap_height() const;
  /// From the baseline down to the lowest of usual letters, > 0.
  [[nodiscard]] double descent() const;
  /// From one baseline to the next.
  [[nodiscard]] double line_height() const { return 1.3 * size_; }

  /// Pixels from the origin of the first letter to where the next would begin. A character that the
  /// font lacks counts as U+FFFD.
  [[nodiscard]] double width(std::string_view text) const;
  /// Draws it from (x, baseline) on.
  void draw(Coverage& coverage, const Point& origin, std::string_view text) const;

  /// Throws InputError, which begins with `what`, unless all of `text` is UTF-8 and in the font: as
  /// letters, not as control characters.
  void check(std::string_view text, const std::string& what) const;

 private:
  struct Library;
  std::unique_ptr<Library> library_;
  double size_;
};

}  // namespace parray::labels
