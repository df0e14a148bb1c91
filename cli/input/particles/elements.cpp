#include "cli/input/particles/elements.h"

#include <algorithm>
#include <array>
#include <optional>

#include "cli/output/picture/srgb.h"
#include "common/base/ascii.h"

namespace parray::input {
namespace {

/// Radii, angstrom, by source:
///
/// Main group: Mantina, Chamberlin, Valero, Cramer and Truhlar, J. Phys. Chem. A 113 (2009) 5806,
/// table 12. They contain the radii of Bondi, J. Phys. Chem. 68 (1964) 441. The radius of hydrogen
/// comes from Rowland and Taylor, J. Phys. Chem. 100 (1996) 7384.
///
/// Transition metals, lanthanides, actinides to Es: Alvarez, Dalton Trans. 42 (2013) 8617, table 1.
/// The table has no radius for Pm: its radius here is the mean of its neighbours.
///
/// From Fm on, no radius is published: 2.00.
///
/// Unknown element: the radius of carbon, the most common element of molecules, in a colour that no
/// element has.
///
/// Colours, 8-bit sRGB: the table of Jmol, "Jmol colors" (jmol.sourceforge.net/jscolors), which
/// extends the convention of Corey, Pauling and Koltun. The table ends at Mt. All later elements
/// have the colour of Mt.
struct Row {
  std::string_view symbol;
  double radius;
  std::uint32_t color;  ///< 0xRRGGBB
};

constexpr std::array<Row, last_element + 1> periodic_table{{
    {"X", 1.70, 0xA89078},  {"H", 1.10, 0xFFFFFF},  {"He", 1.40, 0xD9FFFF}, {"Li", 1.81, 0xCC80FF},
    {"Be", 1.53, 0xC2FF00}, {"B", 1.92, 0xFFB5B5},  {"C", 1.70, 0x909090},  {"N", 1.55, 0x3050F8},
    {"O", 1.52, 0xFF0D0D},  {"F", 1.47, 0x90E050},  {"Ne", 1.54, 0xB3E3F5}, {"Na", 2.27, 0xAB5CF2},
    {"Mg", 1.73, 0x8AFF00}, {"Al", 1.84, 0xBFA6A6}, {"Si", 2.10, 0xF0C8A0}, {"P", 1.80, 0xFF8000},
    {"S", 1.80, 0xFFFF30},  {"Cl", 1.75, 0x1FF01F}, {"Ar", 1.88, 0x80D1E3}, {"K", 2.75, 0x8F40D4},
    {"Ca", 2.31, 0x3DFF00}, {"Sc", 2.58, 0xE6E6E6}, {"Ti", 2.46, 0xBFC2C7}, {"V", 2.42, 0xA6A6AB},
    {"Cr", 2.45, 0x8A99C7}, {"Mn", 2.45, 0x9C7AC7}, {"Fe", 2.44, 0xE06633}, {"Co", 2.40, 0xF090A0},
    {"Ni", 2.40, 0x50D050}, {"Cu", 2.38, 0xC88033}, {"Zn", 2.39, 0x7D80B0}, {"Ga", 1.87, 0xC28F8F},
    {"Ge", 2.11, 0x668F8F}, {"As", 1.85, 0xBD80E3}, {"Se", 1.90, 0xFFA100}, {"Br", 1.83, 0xA62929},
    {"Kr", 2.02, 0x5CB8D1}, {"Rb", 3.03, 0x702EB0}, {"Sr", 2.49, 0x00FF00}, {"Y", 2.75, 0x94FFFF},
    {"Zr", 2.52, 0x94E0E0}, {"Nb", 2.56, 0x73C2C9}, {"Mo", 2.45, 0x54B5B5}, {"Tc", 2.44, 0x3B9E9E},
    {"Ru", 2.46, 0x248F8F}, {"Rh", 2.44, 0x0A7D8C}, {"Pd", 2.15, 0x006985}, {"Ag", 2.53, 0xC0C0C0},
    {"Cd", 2.49, 0xFFD98F}, {"In", 1.93, 0xA67573}, {"Sn", 2.17, 0x668080}, {"Sb", 2.06, 0x9E63B5},
    {"Te", 2.06, 0xD47A00}, {"I", 1.98, 0x940094},  {"Xe", 2.16, 0x429EB0}, {"Cs", 3.43, 0x57178F},
    {"Ba", 2.68, 0x00C900}, {"La", 2.98, 0x70D4FF}, {"Ce", 2.88, 0xFFFFC7}, {"Pr", 2.92, 0xD9FFC7},
    {"Nd", 2.95, 0xC7FFC7}, {"Pm", 2.92, 0xA3FFC7}, {"Sm", 2.90, 0x8FFFC7}, {"Eu", 2.87, 0x61FFC7},
    {"Gd", 2.83, 0x45FFC7}, {"Tb", 2.79, 0x30FFC7}, {"Dy", 2.87, 0x1FFFC7}, {"Ho", 2.81, 0x00FF9C},
    {"Er", 2.83, 0x00E675}, {"Tm", 2.79, 0x00D452}, {"Yb", 2.80, 0x00BF38}, {"Lu", 2.74, 0x00AB24},
    {"Hf", 2.63, 0x4DC2FF}, {"Ta", 2.53, 0x4DA6FF}, {"W", 2.57, 0x2194D6},  {"Re", 2.49, 0x267DAB},
    {"Os", 2.48, 0x266696}, {"Ir", 2.41, 0x175487}, {"Pt", 2.29, 0xD0D0E0}, {"Au", 2.32, 0xFFD123},
    {"Hg", 2.45, 0xB8B8D0}, {"Tl", 1.96, 0xA6544D}, {"Pb", 2.02, 0x575961}, {"Bi", 2.07, 0x9E4FB5},
    {"Po", 1.97, 0xAB5C00}, {"At", 2.02, 0x754F45}, {"Rn", 2.20, 0x428296}, {"Fr", 3.48, 0x420066},
    {"Ra", 2.83, 0x007D00}, {"Ac", 2.80, 0x70ABFA}, {"Th", 2.93, 0x00BAFF}, {"Pa", 2.88, 0x00A1FF},
    {"U", 2.71, 0x008FFF},  {"Np", 2.82, 0x0080FF}, {"Pu", 2.81, 0x006BFF}, {"Am", 2.83, 0x545CF2},
    {"Cm", 3.05, 0x785CE3}, {"Bk", 3.40, 0x8A4FE3}, {"Cf", 3.05, 0xA136D4}, {"Es", 2.70, 0xB31FD4},
    {"Fm", 2.00, 0xB31FBA}, {"Md", 2.00, 0xB30DA6}, {"No", 2.00, 0xBD0D87}, {"Lr", 2.00, 0xC70066},
    {"Rf", 2.00, 0xCC0059}, {"Db", 2.00, 0xD1004F}, {"Sg", 2.00, 0xD90045}, {"Bh", 2.00, 0xE00038},
    {"Hs", 2.00, 0xE6002E}, {"Mt", 2.00, 0xEB0026}, {"Ds", 2.00, 0xEB0026}, {"Rg", 2.00, 0xEB0026},
    {"Cn", 2.00, 0xEB0026}, {"Nh", 2.00, 0xEB0026}, {"Fl", 2.00, 0xEB0026}, {"Mc", 2.00, 0xEB0026},
    {"Lv", 2.00, 0xEB0026}, {"Ts", 2.00, 0xEB0026}, {"Og", 2.00, 0xEB0026},
}};

std::array<Element, periodic_table.size()> elements_of_rows() {
  std::array<Element, periodic_table.size()> elements{};
  for (std::size_t i = 0; i < periodic_table.size(); ++i) {
    const auto& [symbol, radius, color] = periodic_table[i];
    elements[i] = {symbol, radius, linear_of_code(color)};
  }
  return elements;
}

constexpr std::size_t alphabet = 26;
constexpr std::size_t symbol_places = alphabet * (alphabet + 1);

/// Returns the place of a letter in the alphabet, 0 to 25, in either case.
std::optional<std::size_t> letter_in(char c) {
  if (!ascii::is_letter(c)) return {};
  return static_cast<std::size_t>(ascii::lower(c) - 'a');
}

/// Returns the place of a symbol in a table of all texts of one or two letters.
std::optional<std::size_t> place_of(std::string_view symbol) {
  if (symbol.empty() || symbol.size() > 2) return {};
  const auto first = letter_in(symbol[0]);
  const auto second = symbol.size() == 2 ? letter_in(symbol[1]) : alphabet;
  if (!first || !second) return {};
  return *first * (alphabet + 1) + *second;
}

std::array<std::uint8_t, symbol_places> numbers_by_symbol() {
  std::array<std::uint8_t, symbol_places> numbers{};
  for (std::uint8_t i = 1; i <= last_element; ++i) numbers[*place_of(periodic_table[i].symbol)] = i;
  numbers[*place_of("D")] = numbers[*place_of("T")] = 1;
  return numbers;
}

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

const Element& element(std::uint8_t atomic_number) {
  static const std::array<Element, periodic_table.size()> elements = elements_of_rows();
  return elements[atomic_number <= last_element ? atomic_number : 0];
}

std::uint8_t atomic_number_of(std::string_view symbol) {
  static const std::array<std::uint8_t, symbol_places> numbers = numbers_by_symbol();
  const std::optional<std::size_t> place = place_of(symbol);
  return place ? numbers[*place] : 0;
}

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
