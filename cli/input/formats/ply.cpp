#include <algorithm>
#include <atomic>
#include <bit>

#include "cli/input/formats/binary_input.h"
#include "cli/input/formats/format_table.h"
#include "cli/input/formats/ply_header.h"
#include "cli/input/formats/row_layout.h"
#include "cli/output/picture/srgb.h"
#include "common/base/bands.h"
#include "common/base/printable.h"
#include "common/base/text.h"
#include "common/scene/limits.h"

namespace parray::input {
namespace {

Confidence looks_like_ply(const FileStart& start) {
  return certain_if(start.has("ply\n") || start.has("ply\r"));
}

template <typename T>
double ply_value(const char* bytes, bool swapped) {
  return static_cast<double>(binary_value<T>(bytes, swapped));
}

/// Calls `use` with a value of the C++ type of `type` and returns the result.
auto with_ply_type(PlyType type, const auto& use) {
  switch (type) {
    case PlyType::int8: return use(std::int8_t{});
    case PlyType::uint8: return use(std::uint8_t{});
    case PlyType::int16: return use(std::int16_t{});
    case PlyType::uint16: return use(std::uint16_t{});
    case PlyType::int32: return use(std::int32_t{});
    case PlyType::uint32: return use(std::uint32_t{});
    case PlyType::float32: return use(float{});
    default: return use(double{});
  }
}

/// Returns the size of a value in a binary file, in bytes.
std::size_t size_of(PlyType type) {
  return with_ply_type(type, [](auto value) { return sizeof(value); });
}

/// Reads the vertices of binary data as rows of equal size, many at a time.
class PlyRows {
 public:
  /// `vertex` has no lists. `swapped`: its bytes have the opposite order of this machine. `vertex`
  /// and `layout` must outlive this object.
  PlyRows(const PlyElement& vertex, const RowLayout& layout, bool swapped)
      : vertex_(vertex), layout_(layout), swapped_(swapped) {
    for (const PlyProperty& property : vertex.properties) {
      offsets_.push_back(row_bytes_);
      row_bytes_ += size_of(property.type);
    }
  }

  [[nodiscard]] std::size_t row_bytes() const { return row_bytes_; }

  /// Writes `count` rows to the columns of `out` that the layout has, from `first` on. Returns
  /// false if ParticleColumns would reject a row.
  bool read(const char* rows, std::size_t count, Particles& out, std::size_t first) const;

 private:
  bool read_property(std::size_t property, const char* rows, std::size_t count, double least,
                     double most, const auto& put) const {
    const char* const from = rows + offsets_[property];
    return with_ply_type(vertex_.properties[property].type, [&](auto type) {
      bool good = true;
      for (std::size_t i = 0; i < count; ++i) {
        const double value = ply_value<decltype(type)>(from + i * row_bytes_, swapped_);
        good = good && value >= least && value <= most;  // false for NaN
        put(i, value);
      }
      return good;
    });
  }

  bool read_vectors(const std::array<std::size_t, 3>& properties, const char* rows,
                    std::size_t count, double least, double most, Vec3d* to) const {
    const bool x = read_property(properties[0], rows, count, least, most,
                                 [to](std::size_t i, double value) { to[i].x = value; });
    const bool y = read_property(properties[1], rows, count, least, most,
                                 [to](std::size_t i, double value) { to[i].y = value; });
    const bool z = read_property(properties[2], rows, count, least, most,
                                 [to](std::size_t i, double value) { to[i].z = value; });
    return x && y && z;
  }

  const PlyElement& vertex_;
  const RowLayout& layout_;
  bool swapped_;
  std::size_t row_bytes_ = 0;
  std::vector<std::size_t> offsets_;  // in a row, by property
};

bool PlyRows::read(const char* rows, std::size_t count, Particles& out, std::size_t first) const {
  constexpr std::size_t at_once = 512;  // one property at a time, while the rows are in the cache
  bool good = true;
  for (std::size_t done = 0; good && done < count; done += at_once) {
    const char* const from = rows + done * row_bytes_;
    const std::size_t at = first + done;
    const std::size_t some = std::min(at_once, count - done);
    good = read_vectors(layout_.position, from, some, -limits::max_length, limits::max_length,
                        &out.positions[at]);
    if (layout_.radius) {
      good =
          good && read_property(*layout_.radius, from, some, limits::min_radius, limits::max_length,
                                [&](std::size_t i, double value) { out.radii[at + i] = value; });
    }
    for (std::size_t n = 0; n < layout_.numbers.size(); ++n) {
      double* const to = out.numbers[n].values.data() + at;
      read_property(layout_.numbers[n].column, from, some, 0, 0,
                    [to](std::size_t i, double value) { to[i] = value; });
    }
    if (!layout_.color) continue;
    const bool whole = layout_.color_scale == ColorScale::srgb8;
    good = good && read_vectors(*layout_.color, from, some, 0, whole ? 255 : 1, &out.colors[at]);
    for (std::size_t i = 0; whole && good && i < some; ++i) {
      out.colors[at + i] = linear_of_srgb8(out.colors[at + i]);
    }
  }
  return good;
}

[[noreturn]] void fail_end(const ParticleInput& input, const PlyElement& element) {
  input.fail("the file ends within its elements '" + printable(element.name) +
             "': check that the file is complete, and the counts and properties in the header");
}

[[noreturn]] void fail_list(const ParticleInput& input, const PlyProperty& property) {
  input.fail("list '" + printable(property.name) +
             "' has no valid size: check that the header fits the data");
}

/// Reads instances from lines of words. Only the properties that are read must be numbers.
class AsciiReader {
 public:
  explicit AsciiReader(ParticleInput& input) : input_(&input) {}

  /// Goes to the next instance.
  void next(const PlyElement& element) {
    if (!input_->next_filled_line()) fail_end(*input_, element);
    split_at_blanks(input_->line(), words_);
    texts_.resize(element.properties.size());
    std::size_t at = 0;
    for (std::size_t i = 0; i < element.properties.size(); ++i) {
      const PlyProperty& property = element.properties[i];
      if (at == words_.size()) fail_width(element);
      if (property.list_size) {
        const std::optional<std::uint64_t> size = natural_in(words_[at]);
        if (!size) fail_list(*input_, property);
        if (*size >= words_.size() - at) fail_width(element);
        at += 1 + static_cast<std::size_t>(*size);
      } else {
        texts_[i] = words_[at++];
      }
    }
    if (at != words_.size()) fail_width(element);
  }

  /// Returns the value of a property that is not a list.
  [[nodiscard]] double value(std::size_t property) const {
    return number_field(texts_[property], "value", input_->place());
  }

  /// Does the same, but returns NaN for a text that is not a number.
  [[nodiscard]] double number(std::size_t property) const {
    return number_or_nan(texts_[property]);
  }

  /// Adds no vertices: the reader reads text line by line.
  static std::uint64_t add_blocks(const PlyElement&, const RowLayout&, ParticleColumns&, int) {
    return 0;
  }

  void check_end() {
    if (input_->next_filled_line()) {
      input_->fail("text follows the last element: check the counts in the header");
    }
  }

 private:
  [[noreturn]] void fail_width(const PlyElement& element) {
    input_->fail(std::to_string(words_.size()) + " values do not fit the properties of element '" +
                 printable(element.name) +
                 "': write one value for each property; for a list, its length and then its items");
  }

  ParticleInput* input_;
  Fields words_;
  Fields texts_;  // by property
};

/// Reads instances from binary data.
class BinaryReader {
 public:
  BinaryReader(ParticleInput& input, PlyFormat format)
      : input_(&input),
        swapped_((format == PlyFormat::big_endian) != (std::endian::native == std::endian::big)) {}

  /// Goes to the next instance.
  void next(const PlyElement& element) {
    values_.resize(element.properties.size());
    for (std::size_t i = 0; i < element.properties.size(); ++i) {
      const PlyProperty& property = element.properties[i];
      if (!property.list_size) {
        values_[i] = next_value(property.type, element);
        continue;
      }
      const double size = next_value(*property.list_size, element);
      if (size < 0) fail_list(*input_, property);
      const auto bytes = static_cast<std::uint64_t>(size) * size_of(property.type);
      if (!input_->skip_bytes(bytes)) fail_end(*input_, element);
    }
  }

  /// Return the value of a property that is not a list.
  [[nodiscard]] double value(std::size_t property) const { return values_[property]; }

  [[nodiscard]] double number(std::size_t property) const { return values_[property]; }

  /// Adds vertices in blocks, in several threads, until a block has an invalid value. Returns their
  /// number. The caller reads the others one by one, to report the error with its place.
  std::uint64_t add_blocks(const PlyElement& vertex, const RowLayout& layout,
                           ParticleColumns& columns, int threads) {
    constexpr std::uint64_t usual_bytes = 1U << 21;
    const bool has_lists = std::ranges::any_of(
        vertex.properties, [](const auto& property) { return property.list_size.has_value(); });
    if (has_lists || vertex.count == 0) return 0;
    const PlyRows rows(vertex, layout, swapped_);
    const std::uint64_t usual_rows = usual_bytes / rows.row_bytes() + 1;
    std::uint64_t done = 0;
    while (done < vertex.count) {
      const auto count = static_cast<std::size_t>(std::min(usual_rows, vertex.count - done));
      const char* const data = input_->peek_bytes(count * rows.row_bytes());
      if (data == nullptr || !add_block(rows, data, count, layout, columns, threads)) break;
      input_->take_peeked(count * rows.row_bytes());
      done += count;
    }
    return done;
  }

  void check_end() {
    constexpr std::string_view padding = " \t\r\n";  // ends the files of some programs
    while (const char* const byte = input_->next_bytes(1)) {
      if (padding.find(*byte) != std::string_view::npos) continue;
      input_->fail(
          "data follow the last element: check the counts, properties and types in the header");
    }
  }

 private:
  static bool add_block(const PlyRows& rows, const char* data, std::size_t count,
                        const RowLayout& layout, ParticleColumns& columns, int threads) {
    return columns.rows(
        count, layout.radius.has_value(), layout.color.has_value(),
        [&](Particles& particles, std::size_t first) {
          std::atomic<bool> good = true;
          Bands(count, threads).run([&](std::size_t, std::size_t begin, std::size_t end) {
            if (!rows.read(data + begin * rows.row_bytes(), end - begin, particles,
                           first + begin)) {
              good = false;
            }
          });
          return good.load();
        });
  }

  double next_value(PlyType type, const PlyElement& element) {
    const char* bytes = input_->next_bytes(size_of(type));
    if (bytes == nullptr) fail_end(*input_, element);
    return with_ply_type(type,
                         [&](auto value) { return ply_value<decltype(value)>(bytes, swapped_); });
  }

  ParticleInput* input_;
  bool swapped_;
  std::vector<double> values_;  // by property
};

/// Fails if the file is too short for its counts, before memory is allocated for them. Lists may be
/// empty, and numbers in text may have one digit.
void check_size(const PlyHeader& header, const ParticleInput& input) {
  const std::optional<std::uint64_t> left = input.bytes_left();
  if (!left) return;
  const bool text = header.format == PlyFormat::ascii;
  std::uint64_t needed = 0;  // at most 64 elements x 2^32 x 8 KiB
  for (const PlyElement& element : header.elements) {
    for (const PlyProperty& property : element.properties) {
      needed += element.count * (text ? 2 : size_of(property.list_size.value_or(property.type)));
    }
  }
  if (text) needed -= std::min<std::uint64_t>(needed, 1);
  if (needed > *left) {
    input.fail_incomplete("the header requires at least " + std::to_string(needed) +
                          " bytes of data, but only " + std::to_string(*left) + " follow it");
  }
}

/// Returns the scale of colours by the types of their properties.
ColorScale scale_of_colors(const PlyElement& vertex, const std::array<std::size_t, 3>& color,
                           const FilePlace& place) {
  const auto type_of = [&](std::size_t i) { return vertex.properties[color[i]].type; };
  const PlyType type = type_of(0);
  const bool byte = type == PlyType::uint8;
  const bool real = type == PlyType::float32 || type == PlyType::float64;
  if (type_of(1) != type || type_of(2) != type || !(byte || real)) {
    place.fail(
        "the colour properties must be all uchar, all float or all double: change their types");
  }
  return byte ? ColorScale::srgb8 : ColorScale::linear;
}

/// Maps the properties of a vertex to those of a particle.
RowLayout layout_of_vertex(const PlyElement& vertex, const ParticleRequest& request,
                           const FilePlace& place, ParticleColumns& columns) {
  std::vector<std::string> names;
  for (const PlyProperty& property : vertex.properties) {
    names.push_back(property.list_size ? std::string() : property.name);
  }
  for (const std::string_view axis : {"x", "y", "z"}) {
    if (place_in(names, axis)) continue;
    place.fail("element 'vertex' has no scalar property '" + std::string(axis) +
               "': add x, y and z");
  }
  RowLayout layout = layout_of(names, place);
  if (layout.color) layout.color_scale = scale_of_colors(vertex, *layout.color, place);
  for (std::string& name : names) name = lower_case(name);
  want_numbers(other_fields(names, layout), request, layout, columns);
  return layout;
}

/// Adds the vertex at the position of `reader`.
void add_vertex(const auto& reader, const RowLayout& layout, ParticleColumns& columns) {
  const auto vector = [&](const std::array<std::size_t, 3>& at) {
    const double x = reader.value(at[0]);
    const double y = reader.value(at[1]);
    return Vec3d{x, y, reader.value(at[2])};
  };
  columns.position(vector(layout.position));
  if (layout.radius) columns.radius(reader.value(*layout.radius));
  if (layout.color) columns.color(vector(*layout.color), layout.color_scale);
  for (std::size_t i = 0; i < layout.numbers.size(); ++i) {
    columns.number(i, reader.number(layout.numbers[i].column));
  }
}

const PlyElement& vertex_of(const PlyHeader& header, const FilePlace& place) {
  const PlyElement* vertex = nullptr;
  for (const PlyElement& element : header.elements) {
    if (element.name != "vertex") continue;
    if (vertex != nullptr) place.fail("two elements are named 'vertex': rename one");
    vertex = &element;
  }
  if (vertex == nullptr) {
    place.fail(
        "the file has no element 'vertex': add one, because its instances are the particles");
  }
  return *vertex;
}

/// Adds notes on the content that is not particles, mostly the faces of a mesh.
void note_other_elements(const PlyHeader& header, ParticleFacts& facts) {
  for (const PlyElement& element : header.elements) {
    if (element.name == "vertex" || element.count == 0) continue;
    const std::string ending = element.count == 1 ? "" : "s";
    const std::string what = element.name == "face"
                                 ? "face" + ending + " of a mesh"
                                 : "instance" + ending + " of element '" + element.name + "'";
    const std::string key = element.name == "face" ? "faces" : "other_elements";
    facts.notes.push_back({key, element.count, what + " not shown"});
  }
}

Particles read_elements(const PlyHeader& header, ParticleInput& input, auto reader,
                        const ParticleRequest& request) {
  const PlyElement& vertex = vertex_of(header, input.place());
  ParticleColumns columns(input.place());
  if (input.bytes_left()) columns.expect(vertex.count);  // check_size() has checked the count
  const RowLayout layout = layout_of_vertex(vertex, request, input.place(), columns);
  for (const PlyElement& element : header.elements) {
    const bool is_vertex = &element == &vertex;
    std::uint64_t i = is_vertex ? reader.add_blocks(vertex, layout, columns, request.threads) : 0;
    for (; i < element.count; ++i) {
      reader.next(element);
      if (is_vertex) add_vertex(reader, layout, columns);
    }
  }
  reader.check_end();
  Particles particles = columns.finish();
  note_other_elements(header, particles.facts);
  return particles;
}

/// Reads PLY 1.0, ascii and binary in both byte orders. Element "vertex" has x, y, z of any scalar
/// type; radius (or r, without g and b); red, green, blue (or r, g, b). Colours of type uchar are
/// 8-bit sRGB; float and double are linear from 0 to 1. Other properties are numbers on request. A
/// property `scale` is one of these and no radius, because programs use that name for lengths,
/// factors and logarithms. Notes count instances of other elements.
Particles read_ply(PackedFile& file, const ParticleRequest& request) {
  ParticleInput input(file);
  const PlyHeader header = read_ply_header(input);
  check_size(header, input);
  if (header.format == PlyFormat::ascii) {
    return read_elements(header, input, AsciiReader(input), request);
  }
  return read_elements(header, input, BinaryReader(input, header.format), request);
}

}  // namespace

constinit const ParticleFormat ply_format{
    .name = "PLY", .extensions = {".ply"}, .confidence = looks_like_ply, .read = read_ply};

}  // namespace parray::input
