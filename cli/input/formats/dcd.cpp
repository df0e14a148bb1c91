#include <cmath>
#include <numbers>

#include "cli/input/formats/binary_input.h"
#include "cli/input/formats/format_table.h"
#include "cli/input/particles/cell.h"

namespace parray::input {
namespace {

constexpr std::int32_t header_bytes = 84;  // Fortran writes the length of a record before it

/// Recognises trajectories of CHARMM and NAMD in either byte order.
Confidence looks_like_dcd(const FileStart& start) {
  const bool header = start.little_endian(0) == header_bytes ||
                      start.big_endian(0) == header_bytes || start.big_endian(4) == header_bytes;
  const bool kind = start.has("CORD", 4) || start.has("CORD", 8) || start.has("VELD", 4);
  return certain_if(header && kind);
}

/// Places of the header's integers that ParRay uses, out of 20.
enum Control : std::size_t {
  first_step = 1,
  steps_per_frame = 2,
  fixed_atoms = 8,
  has_cell = 10,
  has_fourth = 11,
  charmm_version = 19,
  control_count = 20
};

/// Interprets the six numbers of a unit cell. They are lengths A, B, C and angles in the order A,
/// gamma, B, beta, alpha, C. The angles are in degrees; NAMD and old CHARMM write their cosines.
/// CHARMM from version 25 on writes the lower triangle of a symmetric matrix whose rows are the
/// edges. The values of the angles show which form it is.
std::optional<ParticleCell> dcd_cell(const std::array<double, 6>& six) {
  const auto [a, gamma, b, beta, alpha, c] = six;
  const auto is_cosine = [](double x) { return std::abs(x) <= 1; };
  const auto is_angle = [](double x) { return x >= 0 && x <= 180; };
  if (is_cosine(alpha) && is_cosine(beta) && is_cosine(gamma)) {
    const auto degrees = [](double cosine) {
      return cosine == 0 ? 90 : std::acos(cosine) * 180 / std::numbers::pi;
    };
    return cell_from({a, b, c}, {degrees(alpha), degrees(beta), degrees(gamma)});
  }
  const bool angles = is_angle(alpha) && is_angle(beta) && is_angle(gamma);
  if (angles && a >= 0 && b >= 0 && c >= 0) return cell_from({a, b, c}, {alpha, beta, gamma});
  return valid_cell({{},
                     {Vec3d{six[0], six[1], six[3]}, Vec3d{six[1], six[2], six[4]},
                      Vec3d{six[3], six[4], six[5]}}});
}

class DcdFrames final : public FramesOf<BinaryInput> {
 public:
  DcdFrames(PackedFile& file, const ParticleRequest& request) : FramesOf(file, request) {
    read_header();
  }

  bool next() override {
    if (input_.at_end()) return false;
    first_ = frames_ == 0;
    ++frames_;
    return true;
  }

  std::uint64_t skip() override {
    if (first_ && has_fixed()) {
      read_positions();  // later frames contain only moving atoms, so the positions are needed
    } else {
      input_.skip(frame_bytes());
    }
    return atoms_;
  }

  Particles read() override {
    input_.expect(frame_bytes());
    const std::optional<ParticleCell> cell = read_positions();
    Particles particles = frame_of(positions_, input_.place());
    particles.cell = cell;
    if (control_[steps_per_frame] > 0) {
      particles.facts.time = static_cast<double>(control_[first_step]) +
                             static_cast<double>(frames_ - 1) * control_[steps_per_frame];
    }
    return particles;
  }

 private:
  using Axis = double Vec3d::*;

  void read_header() {
    find_order();
    const std::string kind(input_.bytes(4));
    if (kind == "VELD") {
      input_.fail(
          "the file contains velocities instead of positions: name the file with the positions");
    }
    if (kind != "CORD") fail_other_file();
    for (std::int32_t& value : control_) value = input_.get<std::int32_t>();
    check_length(header_bytes);
    skip_title();
    check_length(4);
    atoms_ = checked_atoms(input_.get<std::int32_t>(), input_.place());
    check_length(4);
    if (has_fixed()) read_moving();
  }

  /// Skips a count and lines of 80 bytes. Some programs write more lines than the length of the
  /// record allows.
  void skip_title() {
    constexpr std::int32_t line_bytes = 80;
    const auto bytes = input_.get<std::int32_t>();
    const auto lines = bytes >= 4 ? input_.get<std::int32_t>() : 0;
    if (bytes < 0 || lines < 0) fail_record();
    const bool whole_lines = bytes >= 4 && (bytes - 4) % line_bytes == 0;
    const std::int64_t rest =
        whole_lines ? std::int64_t{lines} * line_bytes : std::max(bytes - 4, 0);
    input_.skip(static_cast<std::uint64_t>(rest));
    check_length(bytes);
  }

  [[noreturn]] void fail_other_file() const {
    input_.fail(
        "this is not a DCD file, or the lengths of its records have 8 bytes: check that this is "
        "the right file, or convert it to lengths of 4 bytes");
  }

  /// Finds the byte order from the length of the first record.
  void find_order() {
    const std::string_view first = input_.bytes(4);
    if (binary_value<std::int32_t>(first.data(), false) == header_bytes) {
      input_.use_native_order();
    } else if (binary_value<std::int32_t>(first.data(), true) != header_bytes) {
      fail_other_file();
    }
  }

  /// Reads the numbers, from 1, of the atoms that all frames after the first contain.
  void read_moving() {
    const std::int64_t moving = static_cast<std::int64_t>(atoms_) - control_[fixed_atoms];
    if (moving < 0 || control_[fixed_atoms] < 0) {
      input_.fail_damaged("the header has an impossible number of fixed atoms");
    }
    check_length(4 * moving);
    input_.each<std::int32_t>(static_cast<std::uint64_t>(moving), [&](std::int32_t number) {
      if (number < 1 || static_cast<std::uint64_t>(number) > atoms_) {
        input_.fail_damaged("a moving atom does not exist");
      }
      moving_.push_back(static_cast<std::size_t>(number) - 1);
    });
    check_length(4 * moving);
  }

  /// Checks the length of a record. Fortran writes it before and after the record.
  void check_length(std::int64_t bytes) {
    if (input_.get<std::int32_t>() != bytes) fail_record();
  }
  [[noreturn]] void fail_record() const { input_.fail_damaged("a record has the wrong length"); }

  [[nodiscard]] bool has_fixed() const { return control_[fixed_atoms] != 0; }
  /// X-PLOR has a double where CHARMM describes the content of a frame.
  [[nodiscard]] bool says(Control what) const {
    return control_[charmm_version] != 0 && control_[what] != 0;
  }
  [[nodiscard]] std::uint64_t axis_atoms() const {
    return first_ || !has_fixed() ? atoms_ : moving_.size();
  }
  [[nodiscard]] std::uint64_t frame_bytes() const {
    const std::uint64_t axes = says(has_fourth) ? 4 : 3;
    return (says(has_cell) ? cell_bytes + 8 : 0) + axes * (4 * axis_atoms() + 8);
  }

  /// Reads the positions of the frame. Returns its cell.
  std::optional<ParticleCell> read_positions() {
    std::optional<ParticleCell> cell;
    if (says(has_cell)) {
      check_length(cell_bytes);
      std::array<double, 6> six{};
      for (double& value : six) value = input_.get<double>();
      check_length(cell_bytes);
      cell = dcd_cell(six);
    }
    for (const Axis axis : {&Vec3d::x, &Vec3d::y, &Vec3d::z}) read_axis(axis);
    if (says(has_fourth)) input_.skip(4 * axis_atoms() + 8);
    return cell;
  }

  void read_axis(Axis axis) {
    const std::uint64_t count = axis_atoms();
    const bool all = count == atoms_;
    check_length(static_cast<std::int64_t>(4 * count));
    std::size_t i = 0;
    input_.each<float>(count, [&](float value) {
      const std::size_t atom = all ? i : moving_[i];
      if (atom == positions_.size()) positions_.emplace_back();
      positions_[atom].*axis = static_cast<double>(value);
      ++i;
    });
    check_length(static_cast<std::int64_t>(4 * count));
  }

  static constexpr std::int64_t cell_bytes = 48;

  std::array<std::int32_t, control_count> control_{};
  std::uint64_t atoms_ = 0;
  std::vector<std::size_t> moving_;
  std::uint64_t frames_ = 0;  // including the current one
  bool first_ = true;
  std::vector<Vec3d> positions_;  // positions of the frame that was read last
};

}  // namespace

/// Reads DCD (CHARMM, NAMD, X-PLOR, LAMMPS) in both byte orders, with fixed atoms and all forms of
/// the cell. Format: CHARMM documentation, "dynamc", trajectory files. The number of a frame's step
/// is its time.
constinit const ParticleFormat dcd_format = frames_in_angstrom<DcdFrames>(
    "DCD", {".dcd"}, looks_like_dcd, ParticleFormat::Holds::positions);

}  // namespace parray::input
