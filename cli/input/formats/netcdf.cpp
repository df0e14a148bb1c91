#include <algorithm>
#include <array>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "cli/input/formats/binary_input.h"
#include "cli/input/formats/format_table.h"
#include "cli/input/particles/cell.h"

/// The header follows "The NetCDF Classic Format Specification" (OGC 10-092r3), versions 1
/// (classic), 2 (64-bit offset) and 5 (64-bit data). ParRay has its own reader for two reasons:
/// libnetcdf needs HDF5 and curl, and it opens files only by name.
namespace parray::input {
namespace {

using std::string_view_literals::operator""sv;

Confidence looks_like_netcdf(const FileStart& start) {
  return certain_if(start.has("CDF\1"sv) || start.has("CDF\2"sv) || start.has("CDF\5"sv));
}

// Types of values in the file that ParRay reads.
constexpr std::uint32_t type_char = 2;
constexpr std::uint32_t type_float = 5;
constexpr std::uint32_t type_double = 6;

/// Bytes per value, by the number of the type.
constexpr std::array<std::uint64_t, 12> type_bytes{0, 1, 1, 2, 4, 4, 8, 1, 2, 4, 8, 8};

struct NetcdfVariable {
  std::vector<std::uint64_t> shape;  ///< lengths of the dimensions except that of the records
  bool by_record = false;
  std::uint32_t type = 0;
  std::uint64_t offset = 0;  ///< offset of its data in the file, or in the first record
  double scale = 1;          ///< attribute scale_factor
  std::string units;

  [[nodiscard]] bool is_real() const { return type == type_float || type == type_double; }
  /// Returns the number of values per record.
  [[nodiscard]] std::uint64_t count() const {
    std::uint64_t values = 1;
    for (const std::uint64_t length : shape) {
      if (length > 0 && values > UINT64_MAX / length) return UINT64_MAX;
      values *= length;
    }
    return values;
  }
  [[nodiscard]] std::uint64_t bytes() const { return count() * type_bytes.at(type); }
};

struct NetcdfHeader {
  std::map<std::string, NetcdfVariable, std::less<>> variables;
  /// Number of records; not given: until the end of the file.
  std::optional<std::uint64_t> records;
  std::uint64_t record_bytes = 0;

  [[nodiscard]] const NetcdfVariable* find(std::string_view name) const {
    const auto found = variables.find(name);
    return found == variables.end() ? nullptr : &found->second;
  }
};

constexpr std::uint64_t most_items = 10'000;  // in a list
constexpr std::uint64_t most_name_bytes = 1024;
constexpr std::uint64_t most_numbers = std::uint64_t{1} << 40;  // in a variable

struct Attribute {
  std::string text;
  double number = 1;
};

/// Reads the header at the beginning of the file. Fails for other files, for netCDF-4, and for
/// impossible counts.
class HeaderReader {
 public:
  explicit HeaderReader(BinaryInput& input) : input_(input) {}

  NetcdfHeader read() {
    read_version();
    NetcdfHeader header;
    const std::uint64_t records = take_size();
    if (records != (version_ == 5 ? UINT64_MAX : UINT32_MAX)) header.records = records;
    std::vector<std::uint64_t> dimensions;  // lengths; 0: the dimension of the records
    read_list(dimension_tag, [&] {
      take_name();
      dimensions.push_back(take_size());
    });
    read_list(attribute_tag, [&] {
      take_name();
      take_attribute();
    });
    read_list(variable_tag, [&] {
      std::string name = take_name();
      header.variables.insert_or_assign(std::move(name), take_variable(dimensions));
    });
    for (const std::uint64_t bytes : record_parts_) {  // padded, unless there is only one
      header.record_bytes += record_parts_.size() == 1 ? bytes : padded(bytes);
    }
    return header;
  }

 private:
  static constexpr std::uint32_t dimension_tag = 10;
  static constexpr std::uint32_t variable_tag = 11;
  static constexpr std::uint32_t attribute_tag = 12;

  void read_version() {
    const std::string magic(input_.bytes(4));
    if (magic == "\x89HDF") {
      input_.fail("this is a netCDF-4 file: convert it, for example with nccopy -k 64-bit-offset");
    }
    version_ = static_cast<unsigned char>(magic[3]);
    if (!magic.starts_with("CDF") || (version_ != 1 && version_ != 2 && version_ != 5)) {
      input_.fail(
          "this is not a netCDF file: the file does not begin with CDF and version 1, 2 or 5");
    }
  }

  std::uint64_t take_size() {
    return version_ == 5 ? input_.get<std::uint64_t>() : input_.get<std::uint32_t>();
  }

  /// Calls `take` for each item of a list. The list may be absent.
  void read_list(std::uint32_t tag, const auto& take) {
    const auto found = input_.get<std::uint32_t>();
    const std::uint64_t count = take_size();
    if ((found != tag && found + count != 0) || count > most_items) fail_damaged();
    for (std::uint64_t i = 0; i < count; ++i) take();
  }

  std::string take_name() {
    const std::uint64_t bytes = take_size();
    if (bytes > most_name_bytes) fail_damaged();
    std::string name(input_.bytes(static_cast<std::size_t>(padded(bytes))));
    name.resize(static_cast<std::size_t>(bytes));
    return name;
  }

  /// Reads an attribute after its name.
  Attribute take_attribute() {
    const auto type = input_.get<std::uint32_t>();
    const std::uint64_t count = take_size();
    if (type == 0 || type >= type_bytes.size() || count > most_numbers) fail_damaged();
    Attribute attribute;
    const std::uint64_t bytes = padded(count * type_bytes.at(type));
    if (type == type_char && count <= most_name_bytes) {
      attribute.text = input_.bytes(static_cast<std::size_t>(bytes));
      attribute.text.resize(static_cast<std::size_t>(count));
    } else if (type == type_float && count == 1) {
      attribute.number = static_cast<double>(input_.get<float>());
    } else if (type == type_double && count == 1) {
      attribute.number = input_.get<double>();
    } else {
      input_.skip(bytes);
    }
    return attribute;
  }

  NetcdfVariable take_variable(const std::vector<std::uint64_t>& dimensions) {
    NetcdfVariable variable;
    const std::uint64_t rank = take_size();
    if (rank > most_items) fail_damaged();
    for (std::uint64_t i = 0; i < rank; ++i) {
      const std::uint64_t number = take_size();
      if (number >= dimensions.size()) fail_damaged();
      const std::uint64_t length = dimensions[static_cast<std::size_t>(number)];
      const bool of_records = i == 0 && length == 0;
      variable.by_record = variable.by_record || of_records;
      if (!of_records) variable.shape.push_back(length);
    }
    read_list(attribute_tag, [&] {
      const std::string name = take_name();
      const Attribute attribute = take_attribute();
      if (name == "scale_factor") variable.scale = attribute.number;
      if (name == "units") variable.units = attribute.text;
    });
    variable.type = input_.get<std::uint32_t>();
    if (variable.type == 0 || variable.type >= type_bytes.size()) fail_damaged();
    take_size();  // number of bytes, which is not always correct
    variable.offset = version_ == 1 ? input_.get<std::uint32_t>() : input_.get<std::uint64_t>();
    if (variable.count() > most_numbers) fail_damaged();
    if (variable.by_record) record_parts_.push_back(variable.bytes());
    return variable;
  }

  [[noreturn]] void fail_damaged() const { input_.fail_damaged("the netCDF header is not valid"); }

  BinaryInput& input_;
  unsigned version_ = 0;
  std::vector<std::uint64_t> record_parts_;
};

/// Reads trajectories and restart files of AMBER: "AMBER NetCDF Trajectory Convention", version
/// 1.0.
class NetcdfFrames final : public FramesOf<BinaryInput> {
 public:
  NetcdfFrames(PackedFile& file, const ParticleRequest& request)
      : FramesOf(file, request), header_(HeaderReader(input_).read()) {
    positions_ = header_.find("coordinates");
    if (positions_ == nullptr || !positions_->is_real() || positions_->shape.size() != 2 ||
        positions_->shape[1] != 3) {
      input_.fail(
          "the file has no variable coordinates(..., atom, spatial): check that this is a "
          "trajectory of AMBER");
    }
    atoms_ = checked_atoms(static_cast<std::int64_t>(positions_->shape[0]), input_.place());
    // Other variables are read if they have one value per frame like the positions.
    for (const char* name : {"coordinates", "time", "cell_lengths", "cell_angles"}) {
      const NetcdfVariable* const variable = header_.find(name);
      if (variable == nullptr || !variable->is_real()) continue;
      if (variable->by_record != positions_->by_record) continue;
      if (variable == positions_ || variable->count() <= 3) wanted_.push_back(variable);
    }
    std::ranges::sort(wanted_, {}, &NetcdfVariable::offset);
  }

  bool next() override {
    if (next_ >= frames()) return false;
    ++next_;
    return true;
  }

  /// Skips the frame. Fails if the file, unless it is packed, ends within it.
  std::uint64_t skip() override {
    go_to(offset_of(*wanted_.back()));
    input_.expect(wanted_.back()->bytes());
    return atoms_;
  }

  Particles read() override {
    std::map<const NetcdfVariable*, std::vector<double>> values;
    for (const NetcdfVariable* const variable : wanted_) values[variable] = take(*variable);
    const std::vector<double>& numbers = values.at(positions_);
    const bool nm = positions_->units.starts_with("nano");
    const double unit = nm ? angstrom_per_nm : 1;
    std::vector<Vec3d> positions(numbers.size() / 3);
    for (std::size_t i = 0; i < positions.size(); ++i) {
      positions[i] = unit * Vec3d{numbers[3 * i], numbers[3 * i + 1], numbers[3 * i + 2]};
    }
    Particles particles = frame_of(positions, input_.place());
    if (nm) particles.facts.notes.push_back(nm_note(particles.count()));
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

 private:
  /// Returns the number of frames. A restart file has one frame and no records.
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

  [[noreturn]] void fail_damaged() const { input_.fail_damaged("the variables overlap"); }

  std::vector<double> take(const NetcdfVariable& variable) {
    go_to(offset_of(variable));
    input_.expect(variable.bytes());
    std::vector<double> values;
    const auto put = [&](auto value) {
      values.push_back(variable.scale * static_cast<double>(value));
    };
    if (variable.type == type_float) {
      input_.each<float>(variable.count(), put);
    } else {
      input_.each<double>(variable.count(), put);
    }
    return values;
  }

  NetcdfHeader header_;
  const NetcdfVariable* positions_ = nullptr;
  std::vector<const NetcdfVariable*> wanted_;  // in the order of the file
  std::uint64_t atoms_ = 0;
  std::uint64_t next_ = 0;
};

}  // namespace

/// Reads trajectories and restart files of AMBER in classic netCDF (versions 1, 2 and 5).
constinit const ParticleFormat netcdf_format =
    frames_in_angstrom<NetcdfFrames>("AMBER NetCDF", {".nc", ".ncdf", ".ncrst"}, looks_like_netcdf,
                                     ParticleFormat::Holds::positions);

}  // namespace parray::input
