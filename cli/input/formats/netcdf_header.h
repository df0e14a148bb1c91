#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "cli/input/particles/binary_input.h"

/// The header of a classic netCDF file: "The NetCDF Classic Format Specification" (OGC 10-092r3),
/// versions 1 (classic), 2 (64-bit offset) and 5 (64-bit data). Our own reader, because libnetcdf
/// brings HDF5 and curl, and takes a file by its name alone.
namespace parray::input {

/// Type of a variable's numbers.
enum class NetcdfType : std::uint8_t { other, float32, float64 };

struct NetcdfVariable {
  std::vector<std::uint64_t> shape;  ///< without the records' dimension
  std::vector<std::string> dimensions;
  bool by_record = false;
  NetcdfType type{};
  std::uint64_t offset = 0;  ///< of its (first) data
  double scale = 1;          ///< attribute scale_factor
  std::string units;

  [[nodiscard]] std::uint64_t count() const;  ///< of numbers, in a record
  [[nodiscard]] std::uint64_t bytes() const;
};

struct NetcdfHeader {
  std::map<std::string, NetcdfVariable, std::less<>> variables;
  std::optional<std::uint64_t> records;  ///< not given: as many as there are
  std::uint64_t record_bytes = 0;

  [[nodiscard]] const NetcdfVariable* find(std::string_view name) const;
};

/// Reads the header, which the file begins with. Fails for what is no such file, for netCDF-4, and
/// for counts that cannot be.
NetcdfHeader read_netcdf_header(BinaryInput& input);

}  // namespace parray::input
