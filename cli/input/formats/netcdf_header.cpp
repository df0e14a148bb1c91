#include "cli/input/formats/netcdf_header.h"

#include <array>

namespace parray::input {
namespace {

constexpr std::uint64_t most_items = 10'000;  // of a list
constexpr std::uint64_t most_name_bytes = 1024;
constexpr std::uint64_t most_numbers = std::uint64_t{1} << 40;  // of a variable

struct Dimension {
  std::string name;
  std::uint64_t length = 0;  ///< 0: that of the records
};

struct Attribute {
  std::string text;
  double number = 1;
};

class HeaderReader {
 public:
  explicit HeaderReader(BinaryInput& input) : input_(input) {}

  NetcdfHeader read() {
    read_version();
    NetcdfHeader header;
    header.records = read_records();
    std::vector<Dimension> dimensions;
    read_list(dimension_tag, [&] {
      std::string name = take_name();
      dimensions.push_back({std::move(name), take_size()});
    });
    read_list(attribute_tag, [&] {
      take_name();
      take_attribute();
    });
    read_list(variable_tag, [&] {
      std::string name = take_name();
      header.variables.insert_or_assign(std::move(name), take_variable(dimensions));
    });
    find_record_bytes(header);
    return header;
  }

 private:
  static constexpr std::uint32_t dimension_tag = 10;
  static constexpr std::uint32_t variable_tag = 11;
  static constexpr std::uint32_t attribute_tag = 12;

  void read_version() {
    const std::string magic(input_.bytes(4));
    if (magic == "\x89HDF") {
      input_.fail("a netCDF-4 file: convert it, for example with nccopy -k 64-bit-offset");
    }
    version_ = static_cast<unsigned char>(magic[3]);
    if (!magic.starts_with("CDF") || (version_ != 1 && version_ != 2 && version_ != 5)) {
      input_.fail("not a netCDF file: it begins with CDF and a version, 1, 2 or 5");
    }
  }

  std::optional<std::uint64_t> read_records() {
    const std::uint64_t records = take_size();
    const std::uint64_t unknown = version_ == 5 ? UINT64_MAX : UINT32_MAX;
    return records == unknown ? std::nullopt : std::optional(records);
  }

  std::uint64_t take_size() {
    return version_ == 5 ? input_.get<std::uint64_t>() : input_.get<std::uint32_t>();
  }

  /// Calls `take` for each item of a list, which may be absent.
  template <typename Take>
  void read_list(std::uint32_t tag, const Take& take) {
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

  /// After its name.
  Attribute take_attribute() {
    const auto type = input_.get<std::uint32_t>();
    const std::uint64_t count = take_size();
    if (type == 0 || type >= type_bytes.size() || count > most_numbers) fail_damaged();
    Attribute attribute;
    std::uint64_t left = padded(count * type_bytes.at(type));
    if (type == type_char && count <= most_name_bytes) {
      attribute.text = input_.bytes(static_cast<std::size_t>(left));
      attribute.text.resize(static_cast<std::size_t>(count));
      return attribute;
    }
    if (type == type_float && count == 1) {
      attribute.number = static_cast<double>(input_.get<float>());
      left = 0;
    } else if (type == type_double && count == 1) {
      attribute.number = input_.get<double>();
      left = 0;
    }
    input_.skip(left);
    return attribute;
  }

  NetcdfVariable take_variable(const std::vector<Dimension>& dimensions) {
    NetcdfVariable variable;
    const std::uint64_t rank = take_size();
    if (rank > most_items) fail_damaged();
    for (std::uint64_t i = 0; i < rank; ++i) {
      const std::uint64_t number = take_size();
      if (number >= dimensions.size()) fail_damaged();
      const Dimension& dimension = dimensions[static_cast<std::size_t>(number)];
      if (dimension.length == 0 && i == 0) {
        variable.by_record = true;
        continue;
      }
      variable.shape.push_back(dimension.length);
      variable.dimensions.push_back(dimension.name);
    }
    read_list(attribute_tag, [&] {
      const std::string name = take_name();
      const Attribute attribute = take_attribute();
      if (name == "scale_factor") variable.scale = attribute.number;
      if (name == "units") variable.units = attribute.text;
    });
    const auto type = input_.get<std::uint32_t>();
    if (type == 0 || type >= type_bytes.size()) fail_damaged();
    if (type == type_float) variable.type = NetcdfType::float32;
    if (type == type_double) variable.type = NetcdfType::float64;
    take_size();  // its bytes, where they fit into the number
    variable.offset = version_ == 1 ? input_.get<std::uint32_t>() : input_.get<std::uint64_t>();
    if (variable.count() > most_numbers) fail_damaged();
    if (variable.by_record) record_parts_.push_back(variable.count() * type_bytes.at(type));
    return variable;
  }

  /// Each part of a record is padded, unless it is the only one.
  void find_record_bytes(NetcdfHeader& header) const {
    for (const std::uint64_t bytes : record_parts_) {
      header.record_bytes += record_parts_.size() == 1 ? bytes : padded(bytes);
    }
  }

  [[noreturn]] void fail_damaged() const {
    input_.fail("no header of netCDF: is the file damaged?");
  }

  static constexpr std::uint32_t type_char = 2;
  static constexpr std::uint32_t type_float = 5;
  static constexpr std::uint32_t type_double = 6;
  /// By the type's number.
  static constexpr std::array<std::uint64_t, 12> type_bytes{0, 1, 1, 2, 4, 4, 8, 1, 2, 4, 8, 8};

  BinaryInput& input_;
  unsigned version_ = 0;
  std::vector<std::uint64_t> record_parts_;
};

}  // namespace

std::uint64_t NetcdfVariable::count() const {
  std::uint64_t numbers = 1;
  for (const std::uint64_t length : shape) {
    if (length > 0 && numbers > UINT64_MAX / length) return UINT64_MAX;
    numbers *= length;
  }
  return numbers;
}

std::uint64_t NetcdfVariable::bytes() const {
  return count() * (type == NetcdfType::float64 ? 8 : 4);
}

const NetcdfVariable* NetcdfHeader::find(std::string_view name) const {
  const auto found = variables.find(name);
  return found == variables.end() ? nullptr : &found->second;
}

NetcdfHeader read_netcdf_header(BinaryInput& input) { return HeaderReader(input).read(); }

}  // namespace parray::input
