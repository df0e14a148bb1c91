#include <array>

#include "cli/input/formats/binary_frame.h"
#include "cli/input/formats/readers.h"
#include "cli/input/formats/xtc_coordinates.h"
#include "cli/input/particles/binary_input.h"
#include "cli/input/particles/cell.h"
#include "cli/input/particles/frames.h"

/// Trajectories of GROMACS, which are XDR: big-endian, in units of four bytes (RFC 4506). Formats:
/// GROMACS manual, "File formats", xtc and trr.
namespace parray::input {
namespace {

template <typename Real>
std::optional<ParticleCell> take_box(BinaryInput& input) {
  std::array<double, 9> box{};
  for (double& value : box) {
    value = angstrom_per_nm * static_cast<double>(input.get<Real>());
  }
  const auto edge = [&](std::size_t i) { return Vec3d{box.at(i), box.at(i + 1), box.at(i + 2)}; };
  return valid_cell({{}, {edge(0), edge(3), edge(6)}});
}

/// `count` positions as numbers, in nm.
template <typename Real>
std::vector<Vec3d> take_positions(BinaryInput& input, std::uint64_t count) {
  std::vector<Vec3d> positions;
  std::array<double, 3> three{};
  std::size_t filled = 0;
  input.each<Real>(3 * count, [&](Real value) {
    three.at(filled++) = static_cast<double>(value);
    if (filled < three.size()) return;
    positions.push_back({three[0], three[1], three[2]});
    filled = 0;
  });
  return positions;
}

Particles frame_in_nm(std::vector<Vec3d> positions, const FilePlace& place) {
  for (Vec3d& position : positions) position = angstrom_per_nm * position;
  Particles particles = frame_of(positions, place);
  if (particles.count() > 0) particles.facts.notes.push_back(nm_note(particles));
  return particles;
}

class XtcFrames final : public FrameReader {
 public:
  XtcFrames(PackedFile& file, const ParticleRequest& /*request*/) : input_(file) {}

  bool next() override {
    if (input_.at_end()) return false;
    constexpr std::int32_t magic = 1995;
    constexpr std::int32_t magic_of_long_frames = 2023;  // of 64 bits where they count bytes
    const auto found = input_.get<std::int32_t>();
    if (found != magic && found != magic_of_long_frames) {
      input_.fail("no frame of XTC where one should begin: is the file damaged?");
    }
    is_long_ = found == magic_of_long_frames;
    atoms_ = checked_atoms(input_.get<std::int32_t>(), input_.place());
    input_.get<std::int32_t>();  // time step
    time_ = static_cast<double>(input_.get<float>());
    return true;
  }

  std::uint64_t skip() override {
    constexpr std::uint64_t box_bytes = 36;
    constexpr std::uint64_t packing_bytes = 32;
    input_.skip(box_bytes);
    check_atoms();
    if (is_plain()) {
      input_.skip(12 * atoms_);
    } else {
      input_.skip(packing_bytes);
      input_.skip(take_size());
    }
    return atoms_;
  }

  Particles read() override {
    const std::optional<ParticleCell> cell = take_box<float>(input_);
    check_atoms();
    Particles particles = frame_in_nm(
        is_plain() ? take_positions<float>(input_, atoms_) : take_packed(), input_.place());
    particles.cell = cell;
    particles.facts.time = time_;
    return particles;
  }

  [[nodiscard]] const FilePlace& place() const override { return input_.place(); }

 private:
  /// Few atoms are not packed.
  [[nodiscard]] bool is_plain() const { return atoms_ <= 9; }

  /// Their number stands there twice.
  void check_atoms() {
    if (input_.get<std::int32_t>() == static_cast<std::int64_t>(atoms_)) return;
    input_.fail("two numbers of atoms in one frame: is the file damaged?");
  }

  /// Bytes of packed coordinates, with those that fill the last unit.
  std::uint64_t take_size() {
    const std::int64_t bytes = is_long_ ? input_.get<std::int64_t>() : input_.get<std::int32_t>();
    if (bytes < 0) input_.fail("a negative size: is the file damaged?");
    return padded(static_cast<std::uint64_t>(bytes));
  }

  std::vector<Vec3d> take_packed() {
    XtcPacking packing;
    packing.atoms = atoms_;
    packing.precision = static_cast<double>(input_.get<float>());
    for (std::int32_t& value : packing.least) value = input_.get<std::int32_t>();
    for (std::int32_t& value : packing.most) value = input_.get<std::int32_t>();
    packing.small = input_.get<std::int32_t>();
    const std::uint64_t size = take_size();
    input_.expect(size);
    std::string bytes;
    for (std::uint64_t done = 0; done < size;) {
      const std::uint64_t part =
          std::min<std::uint64_t>(size - done, ParticleInput::max_bytes_at_once);
      bytes += input_.bytes(static_cast<std::size_t>(part));
      done += part;
    }
    return unpack_xtc(packing, bytes, input_.place());
  }

  BinaryInput input_;
  bool is_long_ = false;
  std::uint64_t atoms_ = 0;
  double time_ = 0;
};

class TrrFrames final : public FrameReader {
 public:
  TrrFrames(PackedFile& file, const ParticleRequest& /*request*/) : input_(file) {}

  bool next() override {
    if (input_.at_end()) return false;
    read_head();
    return true;
  }

  std::uint64_t skip() override {
    input_.skip(before_box() + sizes_[box] + after_box() + after_positions() + sizes_[positions]);
    return has_positions() ? atoms_ : 0;
  }

  Particles read() override { return is_double_ ? read_reals<double>() : read_reals<float>(); }

  [[nodiscard]] const FilePlace& place() const override { return input_.place(); }

 private:
  /// Parts of a frame, of which each has a size in its head, in the order of both.
  enum Part : std::size_t {
    input_record,
    energies,
    box,
    virial,
    pressure,
    topology,
    symbols,
    positions,
    velocities,
    forces,
    part_count
  };

  void read_head() {
    constexpr std::int32_t magic = 1993;
    constexpr std::uint64_t longest_version = 64;
    if (input_.get<std::int32_t>() != magic) {
      input_.fail("no frame of TRR where one should begin: is the file damaged?");
    }
    input_.get<std::int32_t>();  // length of the version, counted otherwise
    const auto version = input_.get<std::uint32_t>();
    if (version > longest_version) input_.fail("a version that is none: is the file damaged?");
    input_.skip(padded(version));
    for (std::uint64_t& size : sizes_) {
      const auto bytes = input_.get<std::int32_t>();
      if (bytes < 0) input_.fail("a negative size: is the file damaged?");
      size = static_cast<std::uint64_t>(bytes);
    }
    atoms_ = checked_atoms(input_.get<std::int32_t>(), input_.place());
    input_.get<std::int32_t>();  // time step
    input_.get<std::int32_t>();  // number of energies
    find_precision();
    time_ = is_double_ ? input_.get<double>() : static_cast<double>(input_.get<float>());
    input_.skip(is_double_ ? 8 : 4);  // lambda
  }

  void find_precision() {
    is_double_ = false;
    for (const Part part : {positions, velocities, forces}) {
      is_double_ = is_double_ || (sizes_[part] > 0 && sizes_[part] == 24 * atoms_);
    }
    is_double_ = is_double_ || sizes_[box] == 72;
    const std::uint64_t real = is_double_ ? 8 : 4;
    if (has_positions() && sizes_[positions] != 3 * real * atoms_) {
      input_.fail("positions of another size than their number: is the file damaged?");
    }
  }

  [[nodiscard]] bool has_positions() const { return sizes_[positions] > 0; }
  [[nodiscard]] std::uint64_t before_box() const { return sizes_[input_record] + sizes_[energies]; }
  [[nodiscard]] std::uint64_t after_box() const {
    return sizes_[virial] + sizes_[pressure] + sizes_[topology] + sizes_[symbols];
  }
  [[nodiscard]] std::uint64_t after_positions() const {
    return sizes_[velocities] + sizes_[forces];
  }

  template <typename Real>
  Particles read_reals() {
    input_.skip(before_box());
    std::optional<ParticleCell> cell;
    if (sizes_[box] == 9 * sizeof(Real)) {
      cell = take_box<Real>(input_);
    } else {
      input_.skip(sizes_[box]);
    }
    input_.skip(after_box());
    input_.expect(sizes_[positions]);
    Particles particles =
        frame_in_nm(take_positions<Real>(input_, has_positions() ? atoms_ : 0), input_.place());
    input_.skip(after_positions());
    particles.cell = cell;
    particles.facts.time = time_;
    return particles;
  }

  BinaryInput input_;
  std::array<std::uint64_t, part_count> sizes_{};
  std::uint64_t atoms_ = 0;
  bool is_double_ = false;
  double time_ = 0;
};

}  // namespace

Particles read_xtc(PackedFile& file, const ParticleRequest& request) {
  return read_frame<XtcFrames>(file, request);
}

Particles read_trr(PackedFile& file, const ParticleRequest& request) {
  return read_frame<TrrFrames>(file, request);
}

}  // namespace parray::input
