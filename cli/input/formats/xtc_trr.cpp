#include <array>
#include <bit>
#include <cmath>
#include <cstddef>
#include <numeric>

#include "cli/input/formats/binary_input.h"
#include "cli/input/formats/format_table.h"
#include "cli/input/formats/notes.h"
#include "cli/input/particles/cell.h"

/// Trajectories of GROMACS. Lengths in nm become angstrom. The files are XDR: big-endian, in units
/// of four bytes (RFC 4506). Formats: GROMACS manual, "File formats", xtc and trr.
namespace parray::input {
namespace {

constexpr std::int32_t xtc_magic = 1995;
constexpr std::int32_t xtc_magic_of_long_frames = 2023;  // uses 64 bits for byte counts
constexpr std::int32_t trr_magic = 1993;

Confidence looks_like_xtc(const FileStart& start) {
  const std::uint32_t magic = start.big_endian(0);
  const std::uint32_t atoms = start.big_endian(4);  // again after step, time and box
  return certain_if((magic == xtc_magic || magic == xtc_magic_of_long_frames) && atoms > 0 &&
                    start.big_endian(52) == atoms);
}

Confidence looks_like_trr(const FileStart& start) {
  return certain_if(start.big_endian(0) == trr_magic && start.has("GMX_trn_file", 12));
}

/// The part of a frame before the packed coordinates.
struct XtcPacking {
  std::uint64_t atoms = 0;
  double precision = 0;  ///< the unit of coordinates is 1 / precision
  std::array<std::int32_t, 3> least{};
  std::array<std::int32_t, 3> most{};
  std::int32_t small = 0;  ///< index of the first size of small differences
};

__extension__ using Wide = unsigned __int128;
using Whole = std::array<std::int64_t, 3>;
using Sizes = std::array<std::uint64_t, 3>;

/// Sizes of small differences by their index: about 2^(index / 3). The format defines the values.
constexpr std::array<std::uint32_t, 73> small_sizes{
    0,        0,        0,       0,       0,       0,       0,       0,       0,       8,
    10,       12,       16,      20,      25,      32,      40,      50,      64,      80,
    101,      128,      161,     203,     256,     322,     406,     512,     645,     812,
    1024,     1290,     1625,    2048,    2580,    3250,    4096,    5060,    6501,    8192,
    10321,    13003,    16384,   20642,   26007,   32768,   41285,   52015,   65536,   82570,
    104031,   131072,   165140,  208063,  262144,  330280,  416127,  524287,  660561,  832255,
    1048576,  1321122,  1664510, 2097152, 2642245, 3329021, 4194304, 5284491, 6658042, 8388607,
    10568983, 13316085, 16777216};
constexpr std::int32_t first_small = 9;

[[noreturn]] void fail_damaged(const FilePlace& place) {
  place.fail_damaged("the packed coordinates are not valid");
}

/// Reads bits, from the highest to the lowest of each byte.
class Bits {
 public:
  Bits(std::string_view bytes, const FilePlace& place) : bytes_(bytes), place_(place) {}

  /// Returns the next `count` bits, at most 32.
  std::uint64_t take(unsigned count) {
    while (held_ < count) {
      if (next_ == bytes_.size()) fail_damaged(place_);
      held_bits_ = (held_bits_ << 8) | static_cast<unsigned char>(bytes_[next_++]);
      held_ += 8;
    }
    held_ -= count;
    return (held_bits_ >> held_) & ((std::uint64_t{1} << count) - 1);
  }

  /// Returns a number of `count` bits. Its bytes go from low to high; the last one may have fewer
  /// bits.
  Wide take_wide(unsigned count) {
    Wide value = 0;
    for (unsigned at = 0; at < count; at += 8) {
      const unsigned part = std::min(count - at, 8U);
      value |= static_cast<Wide>(take(part)) << at;
    }
    return value;
  }

 private:
  std::string_view bytes_;
  const FilePlace& place_;
  std::size_t next_ = 0;
  std::uint64_t held_bits_ = 0;
  unsigned held_ = 0;
};

/// Splits a number into three digits with the bases `sizes`.
Whole digits_of(auto number, const Sizes& sizes) {
  Whole digits{};
  for (const std::size_t axis : {2U, 1U}) {
    digits.at(axis) = static_cast<std::int64_t>(number % sizes.at(axis));
    number /= sizes.at(axis);
  }
  digits[0] = static_cast<std::int64_t>(number);
  return digits;
}

Whole take_digits(Bits& bits, unsigned count, const Sizes& sizes) {
  const Wide number = bits.take_wide(count);
  constexpr unsigned narrow = 64;  // limit for 64-bit division, which is many times faster
  return count <= narrow ? digits_of(static_cast<std::uint64_t>(number), sizes)
                         : digits_of(number, sizes);
}

Whole sum(const Whole& a, const Whole& b) { return {a[0] + b[0], a[1] + b[1], a[2] + b[2]}; }

/// Unpacks the positions, in nm, that GROMACS packed into `bytes`. Each position is stored in one
/// of two forms. The first is a number in a mixed base that encodes a whole position within the box
/// of `least` and `most`. The second is the difference to the previous position; the size of
/// differences changes from group to group. A bit, and sometimes a count of differences, indicates
/// the form. The first difference after a whole position belongs to the atom before it, because the
/// format stores the oxygen of a water molecule, its middle, first. Format: GROMACS manual, "File
/// formats", xtc; Green, "xdrf library", EMBL 1995; Spångberg, Larsson and van der Spoel, J. Mol.
/// Model. 17 (2011) 2669.
///
/// Throws InputError at `place` for damaged data, before it allocates more memory than the data can
/// need.
class XtcUnpacker {
 public:
  XtcUnpacker(const XtcPacking& packing, std::string_view bytes, const FilePlace& place)
      : packing_(packing), place_(place), bits_(bytes, place), small_(packing.small) {
    for (std::size_t axis = 0; axis < 3; ++axis) {
      least_.at(axis) = packing.least.at(axis);
      const std::int64_t size = std::int64_t{packing.most.at(axis)} - packing.least.at(axis) + 1;
      if (size < 1 || size > UINT32_MAX) fail_damaged(place);
      sizes_.at(axis) = static_cast<std::uint64_t>(size);
      by_axis_ = by_axis_ || size > widest_in_one;
    }
    if (!(packing.precision > 0) || !std::isfinite(packing.precision)) fail_damaged(place);
    check_small();
  }

  std::vector<Vec3d> all() {
    while (positions_.size() < packing_.atoms) take_group();
    return std::move(positions_);
  }

 private:
  static constexpr std::int64_t widest_in_one = 0xFFFFFF;

  /// Reads a position and the differences after it.
  void take_group() {
    Whole position = sum(take_position(), least_);
    int change = 0;
    if (bits_.take(1) == 1) {
      const auto code = static_cast<int>(bits_.take(5));
      change = code % 3 - 1;
      run_ = code / 3;
    }
    if (run_ == 0) {
      put(position);
    } else {
      take_differences(position);
    }
    small_ += change;  // after the last difference, the index may be out of range
  }

  Whole take_position() {
    if (!by_axis_) return take_digits(bits_, bits_in_one(), sizes_);
    Whole digits{};
    for (std::size_t axis = 0; axis < 3; ++axis) {
      digits.at(axis) = static_cast<std::int64_t>(bits_.take(width(sizes_.at(axis))));
    }
    return digits;
  }

  void take_differences(const Whole& position) {
    check_small();
    const std::uint64_t size = small_sizes.at(static_cast<std::size_t>(small_));
    const auto half = static_cast<std::int64_t>(size / 2);
    const Whole back{-half, -half, -half};
    Whole before = position;
    for (int i = 0; i < run_; ++i) {
      const Whole digits = take_digits(bits_, static_cast<unsigned>(small_), {size, size, size});
      before = sum(sum(before, digits), back);
      put(before);
      if (i == 0) put(position);
    }
  }

  void put(const Whole& whole) {
    if (positions_.size() == packing_.atoms) fail_damaged(place_);
    const auto length = [&](std::int64_t x) { return static_cast<double>(x) / packing_.precision; };
    positions_.push_back({length(whole[0]), length(whole[1]), length(whole[2])});
  }

  void check_small() const {
    if (small_ < first_small || static_cast<std::size_t>(small_) >= small_sizes.size()) {
      fail_damaged(place_);
    }
  }

  static unsigned width(std::uint64_t number) {
    return static_cast<unsigned>(std::bit_width(number));
  }
  [[nodiscard]] unsigned bits_in_one() const {
    const Wide product = static_cast<Wide>(sizes_[0]) * sizes_[1] * sizes_[2];
    const auto high = static_cast<std::uint64_t>(product >> 64);
    return high != 0 ? 64 + width(high) : width(static_cast<std::uint64_t>(product));
  }

  const XtcPacking& packing_;
  const FilePlace& place_;
  Bits bits_;
  Whole least_{};
  Sizes sizes_{};
  bool by_axis_ = false;  // true: coordinates are stored separately
  std::int32_t small_;    // index of the current size of differences
  int run_ = 0;           // number of differences after each position, until the next change
  std::vector<Vec3d> positions_;
};

template <typename Real>
std::optional<ParticleCell> take_box(BinaryInput& input) {
  std::array<double, 9> box{};
  for (double& value : box) value = angstrom_per_nm * static_cast<double>(input.get<Real>());
  const auto edge = [&](std::size_t i) { return Vec3d{box.at(i), box.at(i + 1), box.at(i + 2)}; };
  return valid_cell({{}, {edge(0), edge(3), edge(6)}});
}

/// Reads `count` positions as plain numbers, in nm.
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
  add_note(particles.facts.notes, nm_note(particles.count()));
  return particles;
}

class XtcFrames final : public FramesOf<BinaryInput> {
 public:
  using FramesOf::FramesOf;

  bool next() override {
    if (input_.at_end()) return false;
    const auto magic = input_.get<std::int32_t>();
    is_long_ = magic == xtc_magic_of_long_frames;
    if (magic != xtc_magic && !is_long_) input_.fail_damaged("the data are not a frame of XTC");
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

 private:
  /// Returns true if there are too few atoms for packing.
  [[nodiscard]] bool is_plain() const { return atoms_ <= 9; }

  /// Reads the second number of atoms. Fails unless both numbers are equal.
  void check_atoms() {
    if (input_.get<std::int32_t>() == static_cast<std::int64_t>(atoms_)) return;
    input_.fail_damaged("one frame has two different numbers of atoms");
  }

  /// Returns the number of bytes of packed coordinates, including the padding.
  std::uint64_t take_size() {
    const std::int64_t bytes = is_long_ ? input_.get<std::int64_t>() : input_.get<std::int32_t>();
    if (bytes < 0) input_.fail_damaged("the size is negative");
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
    while (bytes.size() < size) {
      bytes += input_.bytes(static_cast<std::size_t>(
          std::min<std::uint64_t>(size - bytes.size(), ParticleInput::max_bytes_at_once)));
    }
    return XtcUnpacker(packing, bytes, input_.place()).all();
  }

  bool is_long_ = false;
  std::uint64_t atoms_ = 0;
  double time_ = 0;
};

class TrrFrames final : public FramesOf<BinaryInput> {
 public:
  using FramesOf::FramesOf;

  bool next() override {
    if (input_.at_end()) return false;
    read_head();
    return true;
  }

  std::uint64_t skip() override {
    input_.skip(bytes_of(input_record, part_count));
    return has_positions() ? atoms_ : 0;
  }

  Particles read() override { return is_double_ ? read_reals<double>() : read_reals<float>(); }

 private:
  /// Parts of a frame in their order. The head has a size for each.
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
    constexpr std::uint64_t longest_version = 64;
    if (input_.get<std::int32_t>() != trr_magic) {
      input_.fail_damaged("the data are not a frame of TRR");
    }
    input_.get<std::int32_t>();  // length of the version, in another form
    const auto version = input_.get<std::uint32_t>();
    if (version > longest_version) input_.fail_damaged("the version is not valid");
    input_.skip(padded(version));
    for (std::uint64_t& size : sizes_) {
      const auto bytes = input_.get<std::int32_t>();
      if (bytes < 0) input_.fail_damaged("a size is negative");
      size = static_cast<std::uint64_t>(bytes);
    }
    atoms_ = checked_atoms(input_.get<std::int32_t>(), input_.place());
    input_.get<std::int32_t>();  // time step
    input_.get<std::int32_t>();  // number of energies
    is_double_ = sizes_[box] == 72;
    for (const Part part : {positions, velocities, forces}) {
      is_double_ = is_double_ || (sizes_[part] > 0 && sizes_[part] == 24 * atoms_);
    }
    const std::uint64_t real = is_double_ ? 8 : 4;
    if (has_positions() && sizes_[positions] != 3 * real * atoms_) {
      input_.fail_damaged("the positions do not fit the number of atoms");
    }
    time_ = is_double_ ? input_.get<double>() : static_cast<double>(input_.get<float>());
    input_.skip(real);  // lambda
  }

  [[nodiscard]] bool has_positions() const { return sizes_[positions] > 0; }
  /// Returns the number of bytes of the parts from `first` on and before `end`.
  [[nodiscard]] std::uint64_t bytes_of(Part first, Part end) const {
    return std::accumulate(sizes_.begin() + first, sizes_.begin() + end, std::uint64_t{0});
  }

  template <typename Real>
  Particles read_reals() {
    input_.skip(bytes_of(input_record, box));
    std::optional<ParticleCell> cell;
    if (sizes_[box] == 9 * sizeof(Real)) {
      cell = take_box<Real>(input_);
    } else {
      input_.skip(sizes_[box]);
    }
    input_.skip(bytes_of(virial, positions));
    input_.expect(sizes_[positions]);
    Particles particles =
        frame_in_nm(take_positions<Real>(input_, has_positions() ? atoms_ : 0), input_.place());
    input_.skip(bytes_of(velocities, part_count));
    particles.cell = cell;
    particles.facts.time = time_;
    return particles;
  }

  std::array<std::uint64_t, part_count> sizes_{};
  std::uint64_t atoms_ = 0;
  bool is_double_ = false;
  double time_ = 0;
};

}  // namespace

constinit const ParticleFormat xtc_format = frames_in_angstrom<XtcFrames>(
    "XTC", {".xtc"}, looks_like_xtc, ParticleFormat::Holds::positions);

constinit const ParticleFormat trr_format = frames_in_angstrom<TrrFrames>(
    "TRR", {".trr"}, looks_like_trr, ParticleFormat::Holds::positions);

}  // namespace parray::input
