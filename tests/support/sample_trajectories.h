#pragma once

#include <array>
#include <bit>
#include <cstdint>
#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "common/math/vec.h"
#include "tests/support/particle_files.h"
#include "tests/support/rooms.h"
#include "tests/support/sample_gsd.h"

/// Small binary trajectory files, written according to the descriptions of their formats.
namespace parray::test {

using Frame = std::vector<Vec3d>;

/// Data of a DCD file other than positions.
struct DcdParts {
  std::endian order = std::endian::little;
  std::vector<std::array<double, 6>> cells{};  ///< one per frame, or empty
  std::vector<std::int32_t>
      moving{};  ///< numbers of atoms, from 1, that later frames contain; empty: all
  bool charmm = true;
  std::int32_t extra_title_lines = 0;  ///< lines that the record's length does not count
};

inline std::string dcd_record(const std::string& bytes, std::endian order) {
  const std::string mark = bytes_of(static_cast<std::int32_t>(bytes.size()), order);
  return mark + bytes + mark;
}

inline std::string dcd_file(const std::vector<Frame>& frames, const DcdParts& parts = {}) {
  const std::endian order = parts.order;
  const auto number = [&](std::size_t value) {
    return bytes_of(static_cast<std::int32_t>(value), order);
  };
  std::array<std::int32_t, 20> control{};
  const std::size_t atoms = frames.at(0).size();
  control[0] = static_cast<std::int32_t>(frames.size());
  control[1] = 100;
  control[2] = 50;
  if (!parts.moving.empty()) control[8] = static_cast<std::int32_t>(atoms - parts.moving.size());
  control[10] = parts.cells.empty() ? 0 : 1;
  control[19] = parts.charmm ? 24 : 0;
  std::string head = "CORD";
  for (const std::int32_t value : control) head += bytes_of(value, order);
  std::string title = number(1) + std::string(80, ' ');
  std::string text = dcd_record(head, order);
  const std::string mark = number(title.size());
  title = number(1 + static_cast<std::size_t>(parts.extra_title_lines)) +
          std::string(80 * (1 + static_cast<std::size_t>(parts.extra_title_lines)), ' ');
  text += mark + title + mark + dcd_record(number(atoms), order);
  if (!parts.moving.empty()) {
    std::string list;
    for (const std::int32_t atom : parts.moving) list += bytes_of(atom, order);
    text += dcd_record(list, order);
  }
  for (std::size_t i = 0; i < frames.size(); ++i) {
    if (!parts.cells.empty()) {
      std::string cell;
      for (const double value : parts.cells.at(i)) cell += bytes_of(value, order);
      text += dcd_record(cell, order);
    }
    for (double Vec3d::*const axis : {&Vec3d::x, &Vec3d::y, &Vec3d::z}) {
      std::string values;
      for (const Vec3d& position : frames[i]) {
        values += bytes_of(static_cast<float>(position.*axis), order);
      }
      text += dcd_record(values, order);
    }
  }
  return text;
}

inline std::string from_hex(std::string_view digits) {
  const auto value = [](char c) { return c <= '9' ? c - '0' : c - 'a' + 10; };
  std::string bytes;
  for (std::size_t i = 0; i + 1 < digits.size(); i += 2) {
    bytes += static_cast<char>(16 * value(digits[i]) + value(digits[i + 1]));
  }
  return bytes;
}

template <typename T>
std::string xdr(T value) {
  return bytes_of(value, std::endian::big);
}

/// Makes an XTC file of at most 9 atoms, which the format does not compress; in nm.
inline std::string plain_xtc_frame(const Frame& frame, float time) {
  const auto count = static_cast<std::int32_t>(frame.size());
  std::string text = xdr(1995) + xdr(count) + xdr(0) + xdr(time);
  for (int i = 0; i < 9; ++i) text += xdr(i % 4 == 0 ? 2.0F : 0.0F);
  text += xdr(count);
  for (const Vec3d& p : frame) {
    for (const double x : {p.x, p.y, p.z}) text += xdr(static_cast<float>(x));
  }
  return text;
}

/// Returns five molecules of water, compressed as differences; time 1.5, box 2, (0.5, 3), 4 nm.
/// Made with GROMACS's library.
inline std::string packed_xtc() {
  return from_hex(
      "000007cb0000000f000000073fc000004000000000000000000000003f0000004040000000000000000000000000"
      "0000408000000000000f447a0000ffffffe8000001f4000001f40000053800000251000002bc0000001500000034"
      "18ec06426542448b35240113a003e286b6d06400ac6d97f554403b10406eb47c5f176893946720ffec8e87a23416"
      "a98734e1d888");
}

/// Returns eleven atoms from -20000 to 18000 nm. Their coordinates are compressed one by one.
inline std::string wide_xtc() {
  return from_hex(
      "000007cb0000000b0000000840200000000000000000000000000000000000000000000000000000000000000000"
      "0000000000000000000b447a0000feced30000000000000000000112a8800000c350000061a8000000420000005a"
      "00000000000000421cfde009c400fa8873f780271007d1115be6807530232a2487ab0186a0c354bfa1d0df9e3b21"
      "f021657890222e17ed4b3393a03b878081fa4413b3815f913c6a5e4cd9d19bbe805793721eac061a861a8880000"
      "0");
}

template <typename Real>
std::string trr_frame(const Frame& frame, Real time) {
  const auto size = [](std::size_t numbers) {
    return xdr(static_cast<std::int32_t>(numbers * sizeof(Real)));
  };
  std::string text = xdr(1993) + xdr(13) + xdr(12) + "GMX_trn_file";
  text += size(0) + size(0) + size(9) + size(0) + size(0) + size(0) + size(0);
  text += size(3 * frame.size()) + size(3 * frame.size()) + size(0);
  text += xdr(static_cast<std::int32_t>(frame.size())) + xdr(7) + xdr(0) + xdr(time) + xdr(Real(0));
  for (int i = 0; i < 9; ++i) text += xdr(Real(i % 4 == 0 ? 3 : 0));
  for (int part = 0; part < 2; ++part) {  // positions, velocities
    for (const Vec3d& p : frame) {
      for (const double x : {p.x, p.y, p.z}) text += xdr(static_cast<Real>(x));
    }
  }
  return text;
}

inline std::string netcdf_name(const std::string& name, int version) {
  const std::string size = version == 5 ? xdr(static_cast<std::uint64_t>(name.size()))
                                        : xdr(static_cast<std::uint32_t>(name.size()));
  return size + name + std::string((4 - name.size() % 4) % 4, '\0');
}

/// Makes an AMBER trajectory: time, coordinates, cell_lengths (10, 20, 30), cell_angles (90, 90,
/// 60).
inline std::string amber_netcdf(const std::vector<Frame>& frames, int version = 2) {
  const auto size = [&](std::uint64_t value) {
    return version == 5 ? xdr(value) : xdr(static_cast<std::uint32_t>(value));
  };
  const auto name = [&](const char* text) { return netcdf_name(text, version); };
  const std::uint64_t atoms = frames.at(0).size();
  const std::string nothing = xdr(0) + size(0);
  struct Variable {
    const char* name;
    std::vector<std::uint64_t> dimensions;
    std::int32_t type;
    std::uint64_t bytes;
  };
  const std::vector<Variable> variables{{"time", {0}, 5, 4},
                                        {"coordinates", {0, 1, 2}, 5, 12 * atoms},
                                        {"cell_lengths", {0, 3}, 6, 24},
                                        {"cell_angles", {0, 3}, 6, 24}};
  const auto header = [&](std::uint64_t begin) {
    std::string text = "CDF" + std::string(1, static_cast<char>(version)) + size(frames.size());
    text += xdr(10) + size(4) + name("frame") + size(0) + name("atom") + size(atoms);
    text += name("spatial") + size(3) + name("cell_spatial") + size(3);
    text += xdr(12) + size(1) + name("Conventions") + xdr(2) + name("AMBER");
    text += xdr(11) + size(variables.size());
    for (const Variable& variable : variables) {
      text += name(variable.name) + size(variable.dimensions.size());
      for (const std::uint64_t dimension : variable.dimensions) text += size(dimension);
      text += nothing + xdr(variable.type) + size(variable.bytes);
      text += version == 1 ? xdr(static_cast<std::uint32_t>(begin)) : xdr(begin);
      begin += variable.bytes;
    }
    return text;
  };
  std::string text = header(header(0).size());
  for (std::size_t i = 0; i < frames.size(); ++i) {
    text += xdr(static_cast<float>(i) * 2.5F);
    for (const Vec3d& p : frames[i]) {
      for (const double x : {p.x, p.y, p.z}) text += xdr(static_cast<float>(x));
    }
    for (const double value : {10.0, 20.0, 30.0, 90.0, 90.0, 60.0}) text += xdr(value);
  }
  return text;
}

inline std::string lammps_data() {
  return "a title\n\n2 atoms\n2 atom types\n0 9 xlo xhi\n0 8 ylo yhi\n0 7 zlo zhi\n1 0 0 xy xz "
         "yz\n\n"
         "Masses\n\n1 12.011 # C\n2 15.999\n\nAtoms # full\n\n2 1 1 -0.5 1 2 3 0 0 0\n"
         "1 1 2 0.5 4 5 6 0 -1 0\n\nVelocities\n\n1 0.1 0.2 0.3\n2 0.4 0.5 0.6\n";
}

inline std::string inpcrd() {
  return "water\n     2  0.1500000E+02\n"
         "   1.0000000   2.0000000   3.0000000   4.0000000   5.0000000   6.0000000\n"
         "  10.0000000  20.0000000  30.0000000  90.0000000  90.0000000  90.0000000\n";
}

inline std::string psf() {
  return "PSF EXT\n\n       1 !NTITLE\n REMARKS water\n\n       3 !NATOM\n"
         "  1 WAT  7    TIP3  OH2  OT  -0.834000  15.9994  0\n"
         "  2 WAT  7    TIP3  H1   HT   0.417000   1.0080  0\n"
         "  3 WAT  7    TIP3  H2   HT   0.417000   1.0080  0\n\n       2 !NBOND\n 1 2 1 3\n";
}

inline std::string prmtop() {
  return "%VERSION  VERSION_STAMP = V0001.000\n%FLAG TITLE\n%FORMAT(a)\nwater\n%FLAG POINTERS\n"
         "%FORMAT(10I8)\n"
         "       3       2       0       0       0       0       0       0       0       0\n"
         "       0       1\n%FLAG ATOM_NAME\n%FORMAT(20a4)\nO   H1  H2  \n%FLAG CHARGE\n"
         "%FORMAT(5E16.8)\n -1.51973982E+01  7.59869910E+00  7.59869910E+00\n%FLAG MASS\n"
         "%FORMAT(5E16.8)\n  1.60000000E+01  1.00800000E+00  1.00800000E+00\n%FLAG RESIDUE_LABEL\n"
         "%FORMAT(20a4)\nWAT \n%FLAG RESIDUE_POINTER\n%FORMAT(10I8)\n       1\n"
         "%FLAG AMBER_ATOM_TYPE\n%FORMAT(20a4)\nOW  HW  HW  \n";
}

/// Returns, by name, a small file of every simulation format that has positions.
inline std::map<std::string, std::string> valid_simulation_files() {
  const Frame one{{1, 2, 3}, {4, 5, 6}, {7, 8, 9}};
  const Frame two{{2, 2, 3}, {4, 6, 6}, {7, 8, 8}};
  DcdParts fixed;
  fixed.moving = {2};
  fixed.cells = {{10, 60, 20, 90, 90, 30}, {10, 90, 20, 90, 90, 30}};
  return {{"a.dcd", dcd_file({one, {{4, 4, 4}}}, fixed)},
          {"a.xtc", packed_xtc() + plain_xtc_frame(two, 1)},
          {"a.trr", trr_frame<float>(one, 0) + trr_frame<double>(two, 1)},
          {"a.nc", amber_netcdf({one, two})},
          {"a.data", lammps_data()},
          {"a.inpcrd", inpcrd()},
          {"a.gsd", sample_gsd()},
          {"b.gsd", sample_gsd(1)}};
}

}  // namespace parray::test
