#include <algorithm>

#include "common/base/printable.h"
#include "common/input/formats/readers.h"
#include "common/input/formats/row_layout.h"
#include "common/input/particles/particle_input.h"
#include "common/input/particles/particle_text.h"

namespace parray {
namespace {

constexpr std::size_t least_row_bytes = 8;  // "C 0 0 0\n"

struct XyzLayout {
  RowLayout row;
  std::size_t columns = 4;  ///< that a row must have
  bool exact = false;       ///< and no more
};

/// One NAME:TYPE:COUNT of Properties.
struct Property {
  std::string_view name;
  char type = 0;
  std::size_t count = 0;
};

/// Takes the text up to the next colon from the front of `text`.
std::string_view take_part(std::string_view& text) {
  const std::size_t end = std::min(text.find(':'), text.size());
  const std::string_view part = text.substr(0, end);
  text.remove_prefix(std::min(end + 1, text.size()));
  return part;
}

Property take_property(std::string_view& text, const FilePlace& place) {
  const std::string_view name = take_part(text);
  const std::string_view type = take_part(text);
  const std::optional<std::uint64_t> count = natural_in(take_part(text));
  constexpr std::string_view types = "SRIL";
  constexpr std::uint64_t max_count = 1000;
  const bool known_type = type.size() == 1 && types.find(type[0]) != std::string_view::npos;
  if (name.empty() || !known_type || count.value_or(0) == 0 || *count > max_count) {
    place.fail("Properties has no NAME:TYPE:COUNT at '" + printable(name) +
               "': write them as species:S:1:pos:R:3");
  }
  return {name, type[0], static_cast<std::size_t>(*count)};
}

/// Enters a property whose first column is `at`.
void enter(const Property& property, std::size_t at, XyzLayout& layout, bool& has_position) {
  const bool three = property.count == 3;
  if (property.name == "species" && property.count == 1) {
    layout.row.element = at;
  } else if (property.name == "pos" && three) {
    layout.row.position = {at, at + 1, at + 2};
    has_position = true;
  } else if (property.name == "radius" && property.count == 1) {
    layout.row.radius = at;
  } else if (property.name == "color" && three) {
    layout.row.color = {{at, at + 1, at + 2}};
    layout.row.color_scale = property.type == 'I' ? ColorScale::srgb8 : ColorScale::linear;
  }
}

XyzLayout layout_of_properties(std::string_view properties, const FilePlace& place) {
  XyzLayout layout;
  layout.exact = true;
  layout.columns = 0;
  bool has_position = false;
  while (!properties.empty()) {
    const Property property = take_property(properties, place);
    enter(property, layout.columns, layout, has_position);
    layout.columns += property.count;
  }
  if (!has_position) place.fail("Properties has no pos:R:3: add it");
  return layout;
}

/// The value of Properties=... in the comment; empty when it is not there.
std::string_view properties_in(std::string_view comment) {
  constexpr std::string_view key = "properties=";
  const std::string lower = lower_case(comment);
  std::size_t at = lower.find(key);
  while (at != std::string::npos && at > 0 && lower[at - 1] != ' ' && lower[at - 1] != '\t') {
    at = lower.find(key, at + 1);  // the end of a longer name
  }
  if (at == std::string::npos) return {};
  std::string_view value = comment.substr(at + key.size());
  const bool quoted = value.starts_with('"');
  if (quoted) value.remove_prefix(1);
  return value.substr(0, value.find_first_of(quoted ? "\"" : " \t"));
}

XyzLayout layout_of_comment(std::string_view comment, const FilePlace& place) {
  const std::string_view properties = properties_in(comment);
  if (!properties.empty()) return layout_of_properties(properties, place);
  XyzLayout plain;
  plain.row.element = 0;
  plain.row.position = {1, 2, 3};
  return plain;
}

void check_width(std::size_t found, const XyzLayout& layout, const FilePlace& place) {
  if (found == layout.columns || (found > layout.columns && !layout.exact)) return;
  place.fail(std::to_string(found) + " columns where " + std::to_string(layout.columns) +
             " are needed: " +
             (layout.exact ? "write as many as Properties announces"
                           : "write a name and three coordinates"));
}

/// Passes over so many frames, to the count of the next.
void skip_frames(ParticleInput& input, std::uint64_t frames) {
  for (std::uint64_t frame = 0; frame < frames; ++frame) {
    const std::uint64_t lines = 1 + count_field(trimmed(input.line()), input.place());
    for (std::uint64_t i = 0; i < lines; ++i) {
      if (!input.next_line()) input.fail("the file ends within a frame: is it complete?");
    }
    if (!input.next_filled_line()) input.fail_without_frame(frame + 1, frames);
  }
}

/// After a frame comes another, which starts with its count, or nothing.
void check_end(ParticleInput& input) {
  if (!input.next_filled_line() || natural_in(trimmed(input.line()))) return;
  input.fail("text after the last particle: is the count on line 1 right?");
}

}  // namespace

Particles read_xyz(PackedFile& file, const ParticleRequest& request) {
  ParticleInput input(file);
  if (!input.next_line()) input.fail("the file is empty: is it complete?");
  skip_frames(input, request.frame_number());
  const std::uint64_t count = count_field(trimmed(input.line()), input.place());
  if (!input.next_line()) input.fail("the file ends before its comment line: is it complete?");
  const XyzLayout layout = layout_of_comment(input.line(), input.place());

  ParticleColumns columns(input.place());
  columns.expect(std::min(count, input.bytes_left().value_or(0) / least_row_bytes + 1));
  Fields row;
  for (std::uint64_t i = 0; i < count; ++i) {
    if (!input.next_line()) {
      input.fail("the file ends after " + std::to_string(i) + " of " + std::to_string(count) +
                 " particles: is it complete?");
    }
    split_at_blanks(input.line(), row);
    check_width(row.size(), layout, input.place());
    add_row(row, layout.row, input.place(), columns);
  }
  check_end(input);
  return columns.finish();
}

}  // namespace parray
