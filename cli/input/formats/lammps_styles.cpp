#include "cli/input/formats/lammps_styles.h"

#include <algorithm>
#include <array>
#include <cstdint>

#include "cli/input/particles/particle_text.h"

namespace parray::input {
namespace {

struct Style {
  std::string_view name;
  std::string_view columns;  ///< before x, y, z; the first is the atom's number
  std::string_view after{};  ///< after x, y, z
};

constexpr std::array<Style, 24> styles{{
    {"atomic", "id type"},
    {"molecular", "id molecule type"},
    {"bond", "id molecule type"},
    {"angle", "id molecule type"},
    {"full", "id molecule type charge"},
    {"charge", "id type charge"},
    {"sphere", "id type diameter density"},
    {"bpm/sphere", "id molecule type diameter density"},
    {"dipole", "id type charge", "mux muy muz"},
    {"dielectric", "id type charge", "normx normy normz area ed em epsilon curvature"},
    {"hybrid", "id type"},
    {"ellipsoid", "id type ellipsoidflag density"},
    {"line", "id molecule type lineflag density"},
    {"tri", "id molecule type triangleflag density"},
    {"body", "id type bodyflag mass"},
    {"peri", "id type volume density"},
    {"dpd", "id type theta"},
    {"edpd", "id type temperature cv"},
    {"mdpd", "id type rho"},
    {"sph", "id type rho esph cv"},
    {"electron", "id type charge espin eradius"},
    {"spin", "id type", "spx spy spz sp"},
    {"tdpd", "id type"},
    {"template", "id type molecule template_index template_atom"},
}};

bool is_whole(std::string_view text) {
  if (text.starts_with('-') || text.starts_with('+')) text.remove_prefix(1);
  return natural_in(text).has_value();
}

bool is_type(std::string_view text, std::uint64_t types) {
  const std::optional<std::uint64_t> number = natural_in(text);
  return number && *number >= 1 && *number <= types;
}

}  // namespace

std::vector<std::string> lammps_style_columns(std::string_view style) {
  const auto* const found = std::ranges::find(styles, style, &Style::name);
  if (found == styles.end()) return {};
  const std::string text = std::string(found->columns) + " x y z " + std::string(found->after);
  std::vector<std::string_view> words;
  split_at_blanks(text, words);
  return {words.begin(), words.end()};
}

std::string_view lammps_style_of(const std::vector<std::string_view>& row, std::uint64_t types) {
  std::size_t columns = row.size();
  constexpr std::size_t flags = 3;
  if (columns >= 8 && std::all_of(row.end() - flags, row.end(), is_whole)) columns -= flags;
  const bool third_is_type = row.size() > 2 && is_type(row[2], types);
  if (columns == 5) return "atomic";
  if (columns == 6) return third_is_type ? "molecular" : "charge";
  if (columns == 7) return third_is_type ? "full" : "sphere";
  return {};
}

}  // namespace parray::input
