#include <algorithm>
#include <array>
#include <map>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "cli/input/formats/format_table.h"
#include "cli/input/formats/gsd_file.h"
#include "cli/input/formats/notes.h"
#include "cli/input/particles/cell.h"
#include "cli/input/particles/particle_columns.h"
#include "cli/input/particles/stated_bonds.h"
#include "common/base/printable.h"
#include "common/base/text.h"

/// Trajectories of HOOMD-blue: GSD files with the schema hoomd (gsd.readthedocs.io, "HOOMD Schema",
/// version 1.4).
namespace parray::input {
namespace {

Confidence looks_like_gsd(const FileStart& start) {
  return certain_if(start.has("\xdf\x65\xdf\x65\xdf\x65\xdf\x65"));
}

constexpr std::string_view particles_folder = "particles/";
constexpr std::string_view logs_folder = "log/particles/";
constexpr std::string_view bonds_count = "bonds/N";
constexpr std::string_view bonds_chunk = "bonds/group";

/// Returns the names of the numeric columns for a chunk with numbers of particles. Returns none for
/// other chunks. A quaternion has its scalar part first.
std::vector<std::string> column_names(std::string_view chunk, std::size_t columns) {
  constexpr std::array<std::string_view, 6> not_columns{"N",      "position", "types",
                                                        "typeid", "diameter", "type_shapes"};
  const bool logged = chunk.starts_with(logs_folder);
  if (!logged && !chunk.starts_with(particles_folder)) return {};
  if (!logged) chunk.remove_prefix(particles_folder.size());
  if (!logged && place_in(not_columns, chunk)) return {};
  if (chunk == "velocity" && columns == 3) return {"vx", "vy", "vz"};
  if (chunk == "image" && columns == 3) return {"ix", "iy", "iz"};
  const std::string name = lower_case(chunk);
  if (columns == 1) return {name};
  constexpr std::array<std::string_view, 4> axes{"w", "x", "y", "z"};
  std::vector<std::string> names;
  for (std::size_t i = 0; i < columns; ++i) {
    const bool vector = columns == 3 || columns == 4;
    const std::string end = vector ? std::string(axes.at(i + 4 - columns)) : std::to_string(i);
    names.push_back(name + "_" + end);
  }
  return names;
}

class GsdFrames final : public FrameReader {
 public:
  GsdFrames(PackedFile& file, const ParticleRequest& request) : file_(file), request_(request) {
    if (file_.schema() != "hoomd") {
      file_.fail("the file has the schema '" + printable(file_.schema()) +
                 "': only files with the schema 'hoomd' have particles");
    }
    for (std::size_t i = 0; i < file_.names().size(); ++i) ids_.try_emplace(file_.names()[i], i);
    next_chunk_ = file_.next_chunk();
  }

  bool next() override {
    if (!next_chunk_) return false;
    chunks_.clear();
    for (; next_chunk_ && next_chunk_->frame == frame_; next_chunk_ = file_.next_chunk()) {
      if (is_used(*next_chunk_)) chunks_.insert_or_assign(next_chunk_->name, *next_chunk_);
    }
    if (frame_ == 0) first_ = chunks_;
    ++frame_;
    return true;
  }

  /// Skips the frame. Fails if the file is known to end within its chunks.
  std::uint64_t skip() override {
    for (const auto& [name, chunk] : chunks_) file_.check(chunk);
    const GsdChunk* const positions = own("particles/position");
    return positions != nullptr ? positions->rows : particle_count();
  }

  Particles read() override {
    count_ = particle_count();
    ParticleColumns columns(file_.place());
    add_positions(columns);
    const std::vector<std::uint32_t> types = add_types(columns);
    const std::uint64_t by_default = add_radii(types, columns);
    add_numbers(columns);
    Particles particles = columns.finish_frame();
    particles.cell = cell();
    add_bonds(particles);
    particles.facts.time = number_of("configuration/step", 0);
    add_note(particles.facts.notes,
             {"default_diameters", by_default,
              in_number(by_default, "particle", "particles") +
                  " with the default diameter 1, because the file states no diameter"});
    return particles;
  }

  [[nodiscard]] const FilePlace& place() const override { return file_.place(); }

 private:
  using Chunks = std::map<std::uint16_t, GsdChunk>;  // by name

  [[nodiscard]] bool is_used(const GsdChunk& chunk) const {
    const std::string_view name = file_.names()[chunk.name];
    return name.starts_with(particles_folder) || name.starts_with(logs_folder) ||
           name == "configuration/box" || name == "configuration/step" || name == bonds_count ||
           name == bonds_chunk;
  }

  /// Returns the chunk of the current frame with this name, or nullptr.
  [[nodiscard]] const GsdChunk* own(std::string_view name) const { return in(chunks_, name); }
  /// Returns the chunk that defines a value of the current frame: its own, or that of frame 0.
  [[nodiscard]] const GsdChunk* inherited(std::string_view name) const {
    const GsdChunk* const chunk = own(name);
    return chunk != nullptr ? chunk : in(first_, name);
  }
  /// Returns the same for a chunk with a row per particle. That of frame 0 defines values only if
  /// both frames have the same number of particles. Fails if the frame's own chunk has another
  /// number of rows.
  const GsdChunk* find(std::string_view name) const {
    const GsdChunk* const chunk = own(name);
    if (chunk != nullptr && chunk->rows != count_) {
      file_.fail_damaged("the chunk " + printable(name) + " has " + std::to_string(chunk->rows) +
                         " rows for " + std::to_string(count_) + " particles");
    }
    const GsdChunk* const found = inherited(name);
    return found != nullptr && found->rows == count_ ? found : nullptr;
  }

  [[nodiscard]] const GsdChunk* in(const Chunks& chunks, std::string_view name) const {
    const auto id = ids_.find(name);
    if (id == ids_.end()) return nullptr;
    const auto found = chunks.find(static_cast<std::uint16_t>(id->second));
    return found == chunks.end() ? nullptr : &found->second;
  }

  void check_columns(const GsdChunk& chunk, std::uint32_t columns) const {
    if (chunk.columns == columns) return;
    file_.fail_damaged("the chunk " + printable(file_.names()[chunk.name]) + " has " +
                       std::to_string(chunk.columns) + " columns instead of " +
                       std::to_string(columns));
  }

  double number_of(std::string_view name, double otherwise) {
    const GsdChunk* const chunk = inherited(name);
    if (chunk == nullptr || chunk->count() != 1) return otherwise;
    double number = otherwise;
    file_.numbers(*chunk, [&](double value) { number = value; });
    return number;
  }

  std::uint64_t particle_count() {
    const double count = number_of("particles/N", 0);
    if (!(count >= 0 && count <= static_cast<double>(INT64_MAX / 2))) {
      file_.fail_damaged("the number of particles is " + number_text(count));
    }
    return checked_atoms(static_cast<std::int64_t>(count), file_.place());
  }

  void add_positions(ParticleColumns& columns) {
    const GsdChunk* const chunk = find("particles/position");
    if (chunk == nullptr) {
      // A file omits positions that are all zero, which makes sense for one particle only.
      if (count_ > 1) {
        file_.fail("frame " + std::to_string(frame_ - 1) +
                   " has no positions: write particles/position");
      }
      if (count_ == 1) columns.position({});
      return;
    }
    check_columns(*chunk, 3);
    file_.check(*chunk);
    if (file_.size()) columns.expect(count_);
    std::array<double, 3> three{};
    std::size_t filled = 0;
    file_.numbers(*chunk, [&](double value) {
      three.at(filled++) = value;
      if (filled < three.size()) return;
      columns.position({three[0], three[1], three[2]});
      filled = 0;
    });
  }

  /// Adds radii: half of the diameters of the particles or, without them, of the shapes of their
  /// types. Returns the number of particles that have neither and get the default.
  std::uint64_t add_radii(const std::vector<std::uint32_t>& types, ParticleColumns& columns) {
    constexpr double default_diameter = 1;
    if (const GsdChunk* const chunk = find("particles/diameter"); chunk != nullptr) {
      check_columns(*chunk, 1);
      file_.numbers(*chunk, [&](double diameter) { columns.radius(diameter / 2); });
      return 0;
    }
    const std::vector<double> of_types = diameters_of_shapes();
    std::uint64_t by_default = 0;
    for (const std::uint32_t type : types) {
      const bool known = type < of_types.size() && of_types[type] > 0;
      columns.radius((known ? of_types[type] : default_diameter) / 2);
      by_default += known ? 0 : 1;
    }
    return by_default;
  }

  /// Returns the diameters of the types that are spheres by particles/type_shapes, which has JSON
  /// texts; 0 for other types. Does not return types after the last one in the file.
  std::vector<double> diameters_of_shapes() {
    std::vector<double> diameters;
    const GsdChunk* const chunk = inherited("particles/type_shapes");
    if (chunk == nullptr || chunk->rows > ParticleColumns::max_types) return diameters;
    if (chunk->columns > GsdFile::max_text_bytes) return diameters;
    for (const std::string& text : file_.texts(*chunk)) {
      const auto shape = nlohmann::json::parse(text, nullptr, false);
      const bool sphere = shape.is_object() && shape.contains("type") &&
                          shape["type"] == "Sphere" && shape.contains("diameter") &&
                          shape["diameter"].is_number();
      diameters.push_back(sphere ? shape["diameter"].get<double>() : 0);
    }
    return diameters;
  }

  [[nodiscard]] std::vector<std::string> type_names() {
    const GsdChunk* const chunk = inherited("particles/types");
    if (chunk == nullptr) return {"A"};
    if (chunk->rows > ParticleColumns::max_types) {
      file_.fail_damaged("the file has " + std::to_string(chunk->rows) + " types of particles");
    }
    std::vector<std::string> names = file_.texts(*chunk);
    for (std::string& name : names) name = printable(name, ParticleColumns::max_type_bytes);
    return names;
  }

  /// Adds the types. Returns the number of each particle's type.
  std::vector<std::uint32_t> add_types(ParticleColumns& columns) {
    std::vector<std::uint32_t> types;
    if (count_ == 0) return types;
    const std::vector<std::string> names = type_names();
    const auto add = [&](double type) {
      if (!(type >= 0 && type < static_cast<double>(names.size()))) {
        file_.fail_damaged("a particle has the type " + number_text(type) + " of " +
                           std::to_string(names.size()) + " types");
      }
      types.push_back(static_cast<std::uint32_t>(type));
      columns.type(names[types.back()]);
    };
    const GsdChunk* const chunk = find("particles/typeid");
    if (chunk == nullptr) {
      for (std::uint64_t i = 0; i < count_; ++i) add(0);
      return types;
    }
    check_columns(*chunk, 1);
    file_.numbers(*chunk, add);
    return types;
  }

  /// Adds the bonds: two particles in a row, counted from 0.
  void add_bonds(Particles& particles) {
    const GsdChunk* const chunk = inherited(bonds_chunk);
    const double count = number_of(bonds_count, 0);
    if (chunk == nullptr || count == 0 || static_cast<double>(chunk->rows) != count) return;
    check_columns(*chunk, 2);
    std::optional<double> first;
    file_.numbers(*chunk, [&](double particle) {
      if (particle == first) {
        file_.fail_damaged("a bond joins the particle " + number_text(particle) + " to itself");
      }
      if (!(particle >= 0 && particle < static_cast<double>(count_))) {
        file_.fail_damaged("a bond has the particle " + number_text(particle) + " of " +
                           std::to_string(count_));
      }
      if (first) {
        particles.bonds.push_back(
            bond_between(static_cast<std::uint64_t>(*first), static_cast<std::uint64_t>(particle)));
      }
      first = first ? std::nullopt : std::optional(particle);
    });
    put_in_order(particles.bonds);
    particles.all_bonds = true;
  }

  /// Adds the numeric columns that the request wants, from chunks with a row per particle.
  void add_numbers(ParticleColumns& columns) {
    std::uint64_t bytes = 0;
    for (const auto& [name, id] : ids_) {
      const GsdChunk* const chunk = inherited(name);
      if (count_ == 0 || chunk == nullptr || chunk->rows != count_) continue;
      if (chunk->type == GsdType::character || chunk->columns > most_columns) continue;
      const std::vector<std::string> names = column_names(name, chunk->columns);
      std::vector<std::optional<std::size_t>> wanted;
      wanted.reserve(names.size());
      for (const std::string& column : names) {
        wanted.push_back(request_.wants(column) ? std::optional(columns.add_numbers(column))
                                                : std::nullopt);
      }
      if (std::ranges::none_of(wanted, [](const auto& column) { return column.has_value(); })) {
        continue;
      }
      bytes += chunk->bytes();
      if (bytes > file_.size().value_or(UINT64_MAX)) file_.fail_damaged("the chunks overlap");
      std::size_t at = 0;
      file_.numbers(*chunk, [&](double value) {
        if (wanted[at]) columns.number(*wanted[at], value);
        at = at + 1 == wanted.size() ? 0 : at + 1;
      });
    }
  }

  /// Returns the box, whose centre is the origin (HOOMD-blue documentation, "Box").
  std::optional<ParticleCell> cell() {
    const GsdChunk* const chunk = inherited("configuration/box");
    if (chunk == nullptr) return {};
    std::vector<double> box;
    if (chunk->count() == 6) file_.numbers(*chunk, [&](double value) { box.push_back(value); });
    if (box.size() != 6) file_.fail_damaged("the box does not have 6 numbers");
    const Vec3d a{box[0], 0, 0};
    const Vec3d b{box[3] * box[1], box[1], 0};
    const Vec3d c{box[4] * box[2], box[5] * box[2], box[2]};
    return valid_cell({-0.5 * (a + b + c), {a, b, c}});
  }

  static constexpr std::uint32_t most_columns = 16;  // of a chunk with numbers of particles

  GsdFile file_;
  ParticleRequest request_;
  std::map<std::string, std::size_t, std::less<>> ids_;  // places of names in the list
  std::optional<GsdChunk> next_chunk_;                   // of a later frame
  std::uint64_t frame_ = 0;                              // number of frames begun
  std::uint64_t count_ = 0;                              // particles of the current frame
  Chunks chunks_;                                        // of the current frame
  Chunks first_;                                         // of frame 0
};

}  // namespace

/// Reads GSD with the schema hoomd. A frame inherits values that it lacks from frame 0, or has
/// defaults. Half the diameter of a particle, or of the sphere that is the shape of its type, is
/// the radius, the step is the time, and the box is the cell. Reads bonds. Numbers: mass, charge,
/// body, vx, ix, orientation_w and so on, and what a simulation logged per particle.
constinit const ParticleFormat gsd_format{.name = "GSD",
                                          .extensions = {".gsd"},
                                          .frames = true,
                                          .confidence = looks_like_gsd,
                                          .read = read_frame<GsdFrames>};

}  // namespace parray::input
