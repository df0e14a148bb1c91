#include "cli/input/formats/recognisers.h"

namespace parray::input {
namespace {

using std::string_view_literals::operator""sv;

}  // namespace

Likeness looks_like_dcd(const FileStart& start) {
  constexpr std::uint32_t first_record = 84;  // bytes, as Fortran writes it before the record
  if (start.little_endian(0) != first_record && start.big_endian(0) != first_record &&
      start.big_endian(4) != first_record) {
    return Likeness::none;
  }
  return certain_if(start.has("CORD", 4) || start.has("CORD", 8) || start.has("VELD", 4));
}

Likeness looks_like_xtc(const FileStart& start) {
  const std::uint32_t magic = start.big_endian(0);
  const std::uint32_t atoms = start.big_endian(4);  // and again after step, time and box
  return certain_if((magic == 1995 || magic == 2023) && atoms > 0 && start.big_endian(52) == atoms);
}

Likeness looks_like_trr(const FileStart& start) {
  return certain_if(start.big_endian(0) == 1993 && start.has("GMX_trn_file", 12));
}

Likeness looks_like_netcdf(const FileStart& start) {
  return certain_if(start.has("CDF\1"sv) || start.has("CDF\2"sv) || start.has("CDF\5"sv));
}

Likeness looks_like_hdf5(const FileStart& start) {
  return certain_if(start.has("\x89HDF\r\n\x1a\n"));
}

Likeness looks_like_gsd(const FileStart& start) {
  constexpr std::uint32_t magic = 0x65DF65DF;
  return certain_if(start.little_endian(0) == magic && start.little_endian(4) == magic);
}

}  // namespace parray::input
