#include "cli/output/labels/font.h"

#include <ft2build.h>
#include FT_FREETYPE_H
#include FT_OUTLINE_H

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <optional>
#include <system_error>

#include "cli/output/labels/canvas.h"
#include "common/base/error.h"
#include "common/base/module.h"
#include "common/base/printable.h"

namespace parray::labels {
namespace {

constexpr double units = 64;  // FreeType's units per pixel
constexpr char32_t replacement = 0xFFFD;

/// Removes the first character from `text` and returns it. If the text is not UTF-8, removes one
/// byte and returns nothing.
std::optional<char32_t> take_character(std::string_view& text) {
  const base::CodePoint first = base::first_code_point(text);
  text.remove_prefix(std::max<std::size_t>(first.length, 1));
  return first.length > 0 ? std::optional(first.value) : std::nullopt;
}

}  // namespace

std::filesystem::path label_font() {
  std::filesystem::path own = base::module_file("DejaVuSans.ttf");
  std::error_code error;
  return std::filesystem::exists(own, error) ? own
                                             : "/usr/share/fonts/truetype/dejavu/DejaVuSans.ttf";
}

struct Font::Library {
  FT_Library library = nullptr;
  FT_Face face = nullptr;

  ~Library() {
    if (face != nullptr) FT_Done_Face(face);
    if (library != nullptr) FT_Done_FreeType(library);
  }

  /// Loads each letter and calls `visit(x)` with its position, from 0 on. Returns the position
  /// after the last letter.
  double each_letter(std::string_view text, const auto& visit) const {
    double x = 0;
    FT_UInt before = 0;
    while (!text.empty()) {
      const char32_t code = take_character(text).value_or(replacement);
      FT_UInt glyph = FT_Get_Char_Index(face, code);
      if (glyph == 0) glyph = FT_Get_Char_Index(face, replacement);
      FT_Vector kerning{};
      if (before != 0 && FT_Get_Kerning(face, before, glyph, FT_KERNING_UNFITTED, &kerning) == 0) {
        x += static_cast<double>(kerning.x) / units;
      }
      before = glyph;
      if (FT_Load_Glyph(face, glyph, FT_LOAD_NO_HINTING | FT_LOAD_NO_BITMAP) != 0) continue;
      visit(x);
      x += static_cast<double>(face->glyph->linearHoriAdvance) / 65536;
    }
    return x;
  }
};

Font::Font(double size, const std::filesystem::path& file)
    : library_(std::make_unique<Library>()), size_(size) {
  std::error_code error;
  if (!std::filesystem::exists(file, error)) {
    throw RunError(file.string() +
                   ": the font of labels, DejaVu Sans, is missing: install fonts-dejavu-core, or "
                   "copy the font to " +
                   base::module_file("DejaVuSans.ttf").string());
  }
  const auto em = static_cast<FT_F26Dot6>(std::lround(size * units));
  if (FT_Init_FreeType(&library_->library) != 0 ||
      FT_New_Face(library_->library, file.c_str(), 0, &library_->face) != 0 ||
      FT_Set_Char_Size(library_->face, em, em, 72, 72) != 0) {
    throw RunError(file.string() +
                   ": the font of labels cannot be read: install again what contains the file: "
                   "fonts-dejavu-core, or ParRay");
  }
}

Font::~Font() = default;

double Font::cap_height() const { return 0.729 * size_; }  // DejaVu Sans: 1493 of 2048 units
double Font::descent() const { return 0.236 * size_; }     // hhea: 483 of 2048 units

double Font::width(std::string_view text) const {
  return library_->each_letter(text, [](double /*x*/) {});
}

void Font::draw(Coverage& coverage, const Point& origin, std::string_view text) const {
  library_->each_letter(text, [&](double advance) {
    auto* const slot = library_->face->glyph;
    const double x = std::floor(origin.x + advance);
    const double y = std::floor(origin.y);
    FT_Outline_Translate(&slot->outline,
                         static_cast<FT_Pos>(std::lround((origin.x + advance - x) * units)),
                         -static_cast<FT_Pos>(std::lround((origin.y - y) * units)));
    if (FT_Render_Glyph(slot, FT_RENDER_MODE_NORMAL) != 0) return;
    const FT_Bitmap& bitmap = slot->bitmap;
    for (int row = 0; row < static_cast<int>(bitmap.rows); ++row) {
      for (int column = 0; column < static_cast<int>(bitmap.width); ++column) {
        const unsigned char share = bitmap.buffer[row * bitmap.pitch + column];
        coverage.add(static_cast<int>(x) + slot->bitmap_left + column,
                     static_cast<int>(y) - slot->bitmap_top + row, static_cast<float>(share) / 255);
      }
    }
  });
}

void Font::check(std::string_view text, const std::string& what) const {
  while (!text.empty()) {
    const std::optional<char32_t> code = take_character(text);
    if (!code) {
      throw InputError(what +
                       ": the text is not UTF-8: use a terminal or a script with that encoding");
    }
    const bool control = *code < 0x20 || (*code >= 0x7F && *code < 0xA0);
    if (!control && FT_Get_Char_Index(library_->face, *code) != 0) continue;
    char name[16];
    static_cast<void>(std::snprintf(name, sizeof name, "U+%04X", static_cast<unsigned>(*code)));
    throw InputError(what + ": the font DejaVu Sans has no character " + name +
                     ": use another character");
  }
}

}  // namespace parray::labels
