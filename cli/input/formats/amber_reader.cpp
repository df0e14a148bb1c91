#include <algorithm>
#include <array>

#include "cli/input/formats/binary_frame.h"
#include "cli/input/formats/netcdf_header.h"
#include "cli/input/formats/readers.h"
#include "cli/input/particles/cell.h"
#include "cli/input/particles/frames.h"
#include "common/base/printable.h"

namespace parray::input {
namespace {

/// Trajectories and restart files of AMBER: "AMBER NetCDF Trajectory Convention", version 1.0.
class NetcdfFrames final : public FrameReader {
 public:
  NetcdfFrames(PackedFile& file, const ParticleRequest& /*request*/)
      : input_(file), header_(read_netcdf_header(input_)) {
    positions_ = header_.find("coordinates");
    if (positions_ == nullptr || positions_->type == NetcdfType::other ||
        positions_->shape.size() != 2 || positions_->shape[1] != 3) {
      input_.fail("no variable coordinates(..., atom, spatial): is this a trajectory of AMBER?");
    }
    atoms_ = checked_atoms(static_cast<std::int64_t>(positions_->shape[0]), input_.place());
    for (const char* name : {"coordinates", "time", "cell_lengths", "cell_angles"}) want(name);
    std::ranges::sort(wanted_, {}, &NetcdfVariable::offset);
  }

  bool next() override {
    if (next_ >= frames()) return false;
    ++next_;
    return true;
  }

  /// A jump, but not beyond the file.
  std::uint64_t skip() override {
    go_to(offset_of(*wanted_.back()));
    input_.expect(wanted_.back()->bytes());
    return atoms_;
  }

  Particles read() override {
    std::map<const NetcdfVariable*, std::vector<double>> found;
    for (const NetcdfVariable* const variable : wanted_) found[variable] = take(*variable);
    return frame(found);
  }

  [[nodiscard]] const FilePlace& place() const override { return input_.place(); }

 private:
  /// Time and cell are optional, and as often there as positions.
  void want(const char* name) {
    const NetcdfVariable* const variable = header_.find(name);
    if (variable == nullptr || variable->type == NetcdfType::other) return;
    if (variable->by_record != positions_->by_record) return;
    if (variable == positions_ || variable->count() <= 3) wanted_.push_back(variable);
  }

  using Values = std::map<const NetcdfVariable*, std::vector<double>>;

  /// A restart file has one, and no records.
  [[nodiscard]] std::uint64_t frames() {
    if (!positions_->by_record) return 1;
    if (header_.records) return *header_.records;
    return input_.at_end() ? next_ : next_ + 1;
  }

  [[nodiscard]] std::uint64_t offset_of(const NetcdfVariable& variable) const {
    const std::uint64_t record = variable.by_record ? next_ - 1 : 0;
    if (header_.record_bytes > 0 && record > UINT64_MAX / 2 / header_.record_bytes) fail_damaged();
    return variable.offset + record * header_.record_bytes;
  }

  void go_to(std::uint64_t offset) {
    if (offset < input_.position()) fail_damaged();
    input_.skip(offset - input_.position());
  }

  [[noreturn]] void fail_damaged() const { input_.fail("variables overlap: is the file damaged?"); }

  std::vector<double> take(const NetcdfVariable& variable) {
    go_to(offset_of(variable));
    input_.expect(variable.bytes());
    std::vector<double> values;
    const auto put = [&](auto value) {
      values.push_back(variable.scale * static_cast<double>(value));
    };
    if (variable.type == NetcdfType::float32) {
      input_.each<float>(variable.count(), put);
    } else {
      input_.each<double>(variable.count(), put);
    }
    return values;
  }

  Particles frame(const Values& values) const {
    const std::vector<double>& numbers = values.at(positions_);
    const bool nm = positions_->units.starts_with("nano");
    const double unit = nm ? angstrom_per_nm : 1;
    std::vector<Vec3d> positions(numbers.size() / 3);
    for (std::size_t i = 0; i < positions.size(); ++i) {
      positions[i] = unit * Vec3d{numbers[3 * i], numbers[3 * i + 1], numbers[3 * i + 2]};
    }
    Particles particles = frame_of(positions, input_.place());
    if (nm) particles.facts.notes.push_back(nm_note(particles));
    const auto three = [&](std::string_view name) {
      const auto found = values.find(header_.find(name));
      if (found == values.end() || found->second.size() != 3) return Vec3d{};
      return Vec3d{found->second[0], found->second[1], found->second[2]};
    };
    particles.cell = cell_from(unit * three("cell_lengths"), three("cell_angles"));
    const auto time = values.find(header_.find("time"));
    if (time != values.end() && time->second.size() == 1) particles.facts.time = time->second[0];
    return particles;
  }

  BinaryInput input_;
  NetcdfHeader header_;
  const NetcdfVariable* positions_ = nullptr;
  std::vector<const NetcdfVariable*> wanted_;  // in the order of the file
  std::uint64_t atoms_ = 0;
  std::uint64_t next_ = 0;
};

}  // namespace

Particles read_netcdf(PackedFile& file, const ParticleRequest& request) {
  return read_frame<NetcdfFrames>(file, request);
}

}  // namespace parray::input
