#pragma once

#include <filesystem>
#include <memory>
#include <string>
#include <string_view>

#include "common/rooms.h"

namespace parray::labels {

class Coverage;
struct Point;

/// Returns the file of DejaVu Sans: the one beside ParRay's modules, which the tarball and Python's
/// wheel contain, otherwise that of Debian's package fonts-dejavu-core.
std::filesystem::path label_font();

/// Draws text in one font and size with FreeType, without hinting and placed to 1/64 of a pixel, so
/// that widths scale with the size. Letters go from left to right with the font's kerning; scripts
/// that need more are drawn letter by letter. Text is UTF-8. Not thread-safe: const functions use a
/// common buffer, too.
class Font {
 public:
  /// `size` is in pixels per em, >= 1. Throws RunError, which names the package, if the file is
  /// missing or is not a font.
  explicit Font(double size, const std::filesystem::path& file = label_font());
  ~Font();
  Font& operator=(Font&&) = delete;

  [[nodiscard]] double size() const { return size_; }
  /// Returns the height of capitals above the baseline, in pixels.
  [[nodiscard]] double cap_height() const;
  /// Returns the depth of usual letters below the baseline, in pixels, > 0.
  [[nodiscard]] double descent() const;
  /// Returns the distance between baselines, in pixels.
  [[nodiscard]] double line_height() const { return 1.3 * size_; }

  /// Returns the width of the text in pixels, up to the origin of the next letter. A character that
  /// the font lacks counts as U+FFFD.
  [[nodiscard]] double width(std::string_view text) const;
  /// Adds text to `coverage`, from `origin` on, which is on the baseline.
  void draw(Coverage& coverage, const Point& origin, std::string_view text) const;

  /// Throws InputError, which begins with `what`, unless `text` is UTF-8 and the font has all its
  /// characters. Control characters are not allowed.
  void check(std::string_view text, const std::string& what) const;

 private:
  struct Library;
  std::unique_ptr<Library> library_;
  double size_;
};

}  // namespace parray::labels
