#include "cli/input/formats/not_shown.h"

#include <algorithm>

#include "common/base/text.h"

namespace parray::input {
namespace {

constexpr std::size_t serial_width = 5;

void note_if_any(std::string_view key, std::uint64_t count, std::string_view one,
                 std::string_view several, ParticleFacts& facts) {
  if (count == 0) return;
  facts.notes.push_back({std::string(key), count, std::string(count == 1 ? one : several)});
}

/// Returns a number for a serial number, which may be hexadecimal or hybrid-36. Returns nothing for
/// texts that no serial number has.
std::optional<std::uint64_t> serial_key(std::string_view serial) {
  constexpr std::size_t longest = 8;
  if (serial.empty() || serial.size() > longest) return {};
  std::uint64_t key = 0;
  for (const char c : serial) key = key << 8U | static_cast<unsigned char>(c);
  return key;
}

/// Returns the serial numbers in the text after the record's name.
std::vector<std::string_view> serials_in(std::string_view text) {
  constexpr std::size_t most = 5;
  std::vector<std::string_view> words;
  split_at_blanks(text, words);
  const bool long_numbers = std::ranges::any_of(words, [](std::string_view word) {
    return word.size() > serial_width && word.size() % serial_width != 0;
  });
  if (long_numbers) return words;
  words.clear();
  for (std::size_t i = 0; i < most && i * serial_width < text.size(); ++i) {
    words.push_back(field_at(text, i * serial_width, serial_width));
  }
  return words;
}

}  // namespace

void note_bonds(std::uint64_t count, ParticleFacts& facts) {
  note_if_any("bonds", count, "bond not shown", "bonds not shown", facts);
}

void note_ellipsoids(std::uint64_t count, ParticleFacts& facts) {
  note_if_any("ellipsoids", count, "ellipsoid shown as a sphere", "ellipsoids shown as spheres",
              facts);
}

void note_bodies(std::uint64_t count, ParticleFacts& facts) {
  note_if_any("bodies", count, "line segment, triangle or body shown as a sphere",
              "line segments, triangles or bodies shown as spheres", facts);
}

void ConectBonds::read(std::string_view record) {
  constexpr std::size_t name_width = 6;
  if (record.size() <= name_width) return;
  const std::vector<std::string_view> serials = serials_in(record.substr(name_width));
  const auto first = serials.empty() ? std::nullopt : serial_key(serials[0]);
  if (!first) return;
  for (std::size_t i = 1; i < serials.size(); ++i) {
    const auto other = serial_key(serials[i]);
    if (other) pairs_.emplace_back(std::min(*first, *other), std::max(*first, *other));
  }
}

std::uint64_t ConectBonds::take() {
  std::ranges::sort(pairs_);
  const auto repeated = std::unique(pairs_.begin(), pairs_.end());
  const auto count = static_cast<std::uint64_t>(repeated - pairs_.begin());
  pairs_.clear();
  return count;
}

EllipsoidRows::EllipsoidRows(const std::vector<std::string_view>& names) {
  const auto x = place_in(names, "shapex");
  const auto y = place_in(names, "shapey");
  const auto z = place_in(names, "shapez");
  if (x && y && z) shape_ = {*x, *y, *z};
  oriented_ = place_in(names, "quatw").has_value();
}

void EllipsoidRows::add(const std::vector<std::string_view>& row) {
  const bool ellipsoid =
      shape_ ? is_ellipsoid(row[(*shape_)[0]], row[(*shape_)[1]], row[(*shape_)[2]]) : oriented_;
  count_ += ellipsoid ? 1 : 0;
}

bool is_ellipsoid(std::string_view x, std::string_view y, std::string_view z) {
  const auto a = number_in(x);
  const auto b = number_in(y);
  const auto c = number_in(z);
  return a && b && c && (*a != *b || *b != *c);
}

}  // namespace parray::input
