#include "cli/input/formats/ply_header.h"

#include <array>
#include <string_view>

#include "common/base/printable.h"
#include "common/base/text.h"

namespace parray::input {
namespace {

using Words = std::vector<std::string_view>;

constexpr std::size_t max_elements = 64;
constexpr std::size_t max_properties = 1024;  // of one element

/// Goes to the next line of the header. Returns its words.
Words next_words(ParticleInput& input) {
  if (!input.next_line()) input.fail_incomplete("the file ends before end_header");
  return words_of(input.line());
}

PlyFormat format_in(const Words& words, const ParticleInput& input) {
  if (words.size() == 3 && words[0] == "format" && words[2] == "1.0") {
    if (words[1] == "ascii") return PlyFormat::ascii;
    if (words[1] == "binary_little_endian") return PlyFormat::little_endian;
    if (words[1] == "binary_big_endian") return PlyFormat::big_endian;
  }
  input.fail(
      "line 2 is not a PLY format: write 'format ascii 1.0', 'format binary_little_endian 1.0' or "
      "'format binary_big_endian 1.0'");
}

PlyType type_in(std::string_view name, const ParticleInput& input) {
  // Two names for each type, in the order of PlyType.
  constexpr std::array<std::string_view, 16> names{
      "char", "int8",  "uchar", "uint8",  "short", "int16",   "ushort", "uint16",
      "int",  "int32", "uint",  "uint32", "float", "float32", "double", "float64"};
  if (const auto place = place_in(names, name)) return static_cast<PlyType>(*place / 2);
  input.fail("unknown type '" + printable(name) +
             "': use char, uchar, short, ushort, int, uint, float or double");
}

PlyElement element_in(const Words& words, const ParticleInput& input) {
  if (words.size() != 3) input.fail("the line is not a valid element: write 'element NAME COUNT'");
  PlyElement element{std::string(words[1]), 0, {}};
  if (element.name == "vertex") {
    element.count = count_field(words[2], input.place());
    return element;
  }
  const std::optional<std::uint64_t> count = natural_in(words[2]);
  if (!count || *count > UINT32_MAX) {
    input.fail("'" + printable(words[2]) + "' is not a number of elements: use 0 to " +
               std::to_string(UINT32_MAX));
  }
  element.count = *count;
  return element;
}

PlyProperty property_in(const Words& words, const ParticleInput& input) {
  if (words.size() == 3) return {std::string(words[2]), type_in(words[1], input), {}};
  if (words.size() != 5 || words[1] != "list") {
    input.fail(
        "the line is not a valid property: write 'property TYPE NAME' or 'property list TYPE TYPE "
        "NAME'");
  }
  const PlyType size = type_in(words[2], input);
  if (size == PlyType::float32 || size == PlyType::float64) {
    input.fail("the size of a list cannot be a " + std::string(words[2]) + ": use uchar or int");
  }
  return {std::string(words[4]), type_in(words[3], input), size};
}

void add_property(const Words& words, PlyHeader& header, const ParticleInput& input) {
  if (header.elements.empty()) {
    input.fail("a property precedes the first element: move the property");
  }
  std::vector<PlyProperty>& properties = header.elements.back().properties;
  if (properties.size() == max_properties) {
    input.fail("the element has more than " + std::to_string(max_properties) +
               " properties: remove some");
  }
  PlyProperty property = property_in(words, input);
  for (const PlyProperty& other : properties) {
    if (other.name != property.name) continue;
    input.fail("two properties are named '" + printable(other.name) + "': rename one");
  }
  properties.push_back(std::move(property));
}

}  // namespace

PlyHeader read_ply_header(ParticleInput& input) {
  if (!input.next_line() || trimmed(input.line()) != "ply") {
    input.fail("this is not a PLY file: its first line is not 'ply'");
  }
  PlyHeader header;
  header.format = format_in(next_words(input), input);
  for (;;) {
    const Words words = next_words(input);
    const std::string_view keyword = words.empty() ? std::string_view() : words[0];
    if (keyword == "end_header") break;
    if (keyword == "comment" || keyword == "obj_info") continue;
    if (keyword == "element") {
      if (header.elements.size() == max_elements) {
        input.fail("the header has more than " + std::to_string(max_elements) +
                   " elements: remove some");
      }
      header.elements.push_back(element_in(words, input));
    } else if (keyword == "property") {
      add_property(words, header, input);
    } else {
      input.fail("'" + printable(input.line()) +
                 "' is unknown in a PLY header: use comment, element, property or end_header");
    }
  }
  for (const PlyElement& element : header.elements) {
    if (element.count > 0 && element.properties.empty()) {
      input.fail("element '" + printable(element.name) + "' has no properties: add them");
    }
  }
  return header;
}

}  // namespace parray::input
