#include "cli/input/particles/crystal_radii.h"

#include <algorithm>
#include <array>

namespace parray::input {
namespace {

constexpr std::size_t in_table = 97;
using Picometres = std::array<double, in_table>;  ///< by atomic number

// clang-format off
constexpr Picometres covalent{
     76,                                                                       // unknown
     31,  28,                                                                  // H, He
    128,  96,  84,  76,  71,  66,  57,  58,                                    // Li to Ne
    166, 141, 121, 111, 107, 105, 102, 106,                                    // Na to Ar
    203, 176, 170, 160, 153, 139, 139, 132, 126, 124, 132, 122,                // K to Zn
    122, 120, 119, 120, 120, 116,                                              // Ga to Kr
    220, 195, 190, 175, 164, 154, 147, 146, 142, 139, 145, 144,                // Rb to Cd
    142, 139, 139, 138, 139, 140,                                              // In to Xe
    244, 215,                                                                  // Cs, Ba
    207, 204, 203, 201, 199, 198, 198, 196, 194, 192, 192, 189, 190, 187, 187, // La to Lu
    175, 170, 162, 151, 144, 141, 136, 136, 132,                               // Hf to Hg
    145, 146, 148, 140, 150, 150,                                              // Tl to Rn
    260, 221, 215, 206, 200, 196, 190, 187, 180, 169};                         // Fr to Cm

/// 0: not in the table.
constexpr Picometres metallic{
      0,                                                                       // unknown
      0,   0,                                                                  // H, He
    152, 112,   0,   0,   0,   0,   0,   0,                                    // Li to Ne
    186, 160, 143,   0,   0,   0,   0,   0,                                    // Na to Ar
    227, 197, 162, 147, 134, 128, 127, 126, 125, 124, 128, 134,                // K to Zn
    135,   0,   0,   0,   0,   0,                                              // Ga to Kr
    248, 215, 180, 160, 146, 139, 136, 134, 134, 137, 144, 151,                // Rb to Cd
    167,   0,   0,   0,   0,   0,                                              // In to Xe
    265, 222,                                                                  // Cs, Ba
    187, 181.8, 182.4, 181.4, 183.4, 180.4, 180.4, 180.4, 177.3, 178.1,        // La to Dy
    176.2, 176.1, 175.9, 176, 173.8,                                           // Ho to Lu
    159, 146, 139, 137, 135, 135.5, 138.5, 144, 151,                           // Hf to Hg
    170, 175,   0,   0,   0,   0,                                              // Tl to Rn
      0,   0,   0, 179, 163, 156, 155, 159, 173, 174};                         // Fr to Cm
// clang-format on

double in_angstrom(const Picometres& table, std::uint8_t atomic_number) {
  return table.at(std::min<std::size_t>(atomic_number, in_table - 1)) / 100;
}

}  // namespace

double covalent_radius(std::uint8_t atomic_number) { return in_angstrom(covalent, atomic_number); }

double crystal_radius(std::uint8_t atomic_number) {
  const double radius = in_angstrom(metallic, atomic_number);
  return radius > 0 ? radius : covalent_radius(atomic_number);
}

bool is_metal(std::uint8_t atomic_number) { return in_angstrom(metallic, atomic_number) > 0; }

bool is_noble_gas(std::uint8_t atomic_number) {
  constexpr std::array<std::uint8_t, 6> gases{2, 10, 18, 36, 54, 86};
  return std::ranges::find(gases, atomic_number) != gases.end();
}

bool is_ionic(std::uint8_t atomic_number) {
  constexpr std::array<std::uint8_t, 12> ions{3, 4, 11, 12, 19, 20, 37, 38, 55, 56, 87, 88};
  return std::ranges::find(ions, atomic_number) != ions.end();
}

}  // namespace parray::input
