#include "cli/input/formats/crystal.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstddef>
#include <map>
#include <utility>

#include "cli/input/formats/gemmi_seam.h"
#include "cli/input/particles/cell.h"
#include "common/base/ascii.h"
#include "common/base/printable.h"
#include "common/base/text.h"

namespace parray::input {
namespace {

/// Scans one of the three parts of an operation. Skips blanks.
class Part {
 public:
  explicit Part(std::string_view text) : text_(text) {}

  char peek() {
    while (!text_.empty() && ascii::is_blank(text_[0])) text_.remove_prefix(1);
    return text_.empty() ? '\0' : text_[0];
  }
  bool take(char c) {
    if (peek() != c) return false;
    text_.remove_prefix(1);
    return true;
  }
  std::optional<double> number() {
    peek();
    double value = 0;
    const auto [stop, error] =
        std::from_chars(text_.data(), text_.data() + text_.size(), value, std::chars_format::fixed);
    if (error != std::errc()) return {};
    text_.remove_prefix(static_cast<std::size_t>(stop - text_.data()));
    return value;
  }
  /// Returns 0 to 2 for x, y, z.
  std::optional<std::size_t> axis() {
    constexpr std::string_view letters = "xyzXYZ";
    const std::size_t at = letters.find(peek());
    if (at == std::string_view::npos) return {};
    text_.remove_prefix(1);
    return at % 3;
  }

 private:
  std::string_view text_;
};

/// Parses a number or a fraction.
std::optional<double> fraction_in(Part& part) {
  const std::optional<double> number = part.number();
  if (!number || !part.take('/')) return number;
  const std::optional<double> denominator = part.number();
  if (!denominator || *denominator == 0) return {};
  return *number / *denominator;
}

/// Parses terms such as "-x", "+1/2", "2*x", "x/2" and adds them to a row of the matrix.
bool read_row(std::string_view text, double* row) {
  Part part(text);
  if (part.peek() == '\0') return false;
  while (part.peek() != '\0') {
    double factor = part.take('-') ? -1 : 1;
    if (factor > 0) part.take('+');
    std::optional<std::size_t> axis;
    if (ascii::is_digit(part.peek()) || part.peek() == '.') {
      const auto number = fraction_in(part);
      if (!number) return false;
      factor *= *number;
      const bool times = part.take('*');
      axis = part.axis();
      if (times && !axis) return false;
    } else {
      axis = part.axis();
      if (!axis) return false;
      if (part.take('/')) {
        const auto denominator = part.number();
        if (!denominator || *denominator == 0) return false;
        factor /= *denominator;
      }
    }
    if (!std::isfinite(factor)) return false;
    row[axis.value_or(3)] += factor;
  }
  return true;
}

Vec3d placed(const ParticleCell& cell, const Vec3d& fraction) {
  return fraction.x * cell.edges[0] + fraction.y * cell.edges[1] + fraction.z * cell.edges[2];
}

/// Maps a fraction into [0, 1). A value just below 1 is a rounding error and becomes 0.
double wrapped(double fraction) {
  constexpr double rounding = 1e-6;
  const double part = fraction - std::floor(fraction);
  return part > 1 - rounding ? 0 : part;
}

double nearest_image(double difference) { return difference - std::round(difference); }

double periodic_distance(const ParticleCell& cell, const Vec3d& a, const Vec3d& b) {
  const Vec3d d = a - b;
  return length(placed(cell, {nearest_image(d.x), nearest_image(d.y), nearest_image(d.z)}));
}

Vec3d image_of(const SymmetryOperation& operation, const Vec3d& f) {
  const auto row = [&](std::size_t i) {
    const double* r = operation.data() + 4 * i;
    return wrapped(r[0] * f.x + r[1] * f.y + r[2] * f.z + r[3]);
  };
  return {row(0), row(1), row(2)};
}

/// Returns a key that is equal for sites at the same place.
std::array<long, 3> site_key(const CrystalSite& site) {
  constexpr double steps = 10000;  // steps along an edge
  const auto key = [](double fraction) { return std::lround(steps * wrapped(fraction)); };
  return {key(site.fraction.x), key(site.fraction.y), key(site.fraction.z)};
}

/// Keeps one group of each assembly and one of several sites at the same place: that with the
/// highest occupancy, or the first of equals. Returns the removed sites.
std::vector<CrystalSite> leave_one(std::vector<CrystalSite>& sites,
                                   const AlternativeChoice& choice) {
  Choices<std::string, std::string> groups(choice);  // by assembly
  for (const CrystalSite& site : sites) {
    if (!site.group.empty()) groups.offer(site.assembly, site.group, site.occupancy, site.group);
  }
  std::map<std::array<long, 3>, const CrystalSite*> best;
  const auto in_group = [&](const CrystalSite& site) {
    return site.group.empty() || groups.of(site.assembly) == site.group;
  };
  for (const CrystalSite& site : sites) {
    if (!in_group(site)) continue;
    const auto [known, fresh] = best.try_emplace(site_key(site), &site);
    if (!fresh && site.occupancy > known->second->occupancy) known->second = &site;
  }
  std::vector<CrystalSite> kept;
  std::vector<CrystalSite> out;
  for (const CrystalSite& site : sites) {
    const bool stays = in_group(site) && best.at(site_key(site)) == &site;
    (stays ? kept : out).push_back(site);
  }
  sites = std::move(kept);
  return out;
}

/// Returns the positions of the site under all operations, inside the cell and without repetitions.
std::vector<Vec3d> images_of(const CrystalSite& site, const ParticleCell& cell,
                             const std::vector<SymmetryOperation>& operations) {
  constexpr double same_site = 0.4;  // angstrom
  std::vector<Vec3d> images;
  for (const SymmetryOperation& operation : operations) {
    const Vec3d image = image_of(operation, site.fraction);
    const bool known = std::ranges::any_of(images, [&](const Vec3d& other) {
      return periodic_distance(cell, image, other) < same_site;
    });
    if (!known) images.push_back(image);
  }
  return images;
}

std::vector<SymmetryOperation> operations_of(const Crystal& crystal, const FilePlace& place) {
  constexpr std::size_t most = 1000;  // the largest groups of centred cells have 192
  if (crystal.operations.empty()) return operations_of_space_group(crystal.space_group);
  if (crystal.operations.size() > most) {
    place.fail("more than " + std::to_string(most) + " symmetry operations: remove some");
  }
  std::vector<SymmetryOperation> operations;
  for (const std::string& text : crystal.operations) {
    const auto operation = symmetry_operation_in(text);
    if (!operation) {
      place.fail("'" + printable(text) +
                 "' is not a symmetry operation: write an operation such as 'x, y+1/2, -z'");
    }
    operations.push_back(*operation);
  }
  return operations;
}

}  // namespace

std::optional<SymmetryOperation> symmetry_operation_in(std::string_view text) {
  SymmetryOperation operation{};
  const std::vector<std::string_view> rows = split_at(',', text);
  if (rows.size() != 3) return {};
  for (std::size_t i = 0; i < rows.size(); ++i) {
    if (!read_row(rows[i], operation.data() + 4 * i)) return {};
  }
  return operation;
}

Particles unit_cell(Crystal crystal, const ParticleRequest& request, const FilePlace& place) {
  const std::optional<ParticleCell> cell = cell_from(crystal.lengths, crystal.angles);
  if (!cell) {
    place.fail(
        "the coordinates are fractions, but the file has no valid cell: add or correct "
        "_cell_length_a, _cell_length_b, _cell_length_c and the angles");
  }
  std::vector<SymmetryOperation> operations = operations_of(crystal, place);
  AtomColumns atoms(place, request, {"occupancy", "b_factor"});
  if (operations.empty()) {
    atoms.note({"unknown_symmetry", crystal.sites.size(),
                in_number(crystal.sites.size(), "site", "sites") +
                    " shown without symmetry, because the file names no known symmetry"});
    operations.push_back({1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0});
  }
  std::uint64_t left_out = 0;
  if (request.alternatives.rule != AlternativeChoice::Rule::all) {
    for (const CrystalSite& site : leave_one(crystal.sites, request.alternatives)) {
      left_out += images_of(site, *cell, operations).size();
    }
  }
  std::uint64_t partial = 0;
  for (const CrystalSite& site : crystal.sites) {
    const std::vector<Vec3d> images = images_of(site, *cell, operations);
    if (site.occupancy < 1) partial += images.size();
    for (const Vec3d& image : images) {
      atoms.add({.position = placed(*cell, image), .name = site.label, .element = site.element});
      atoms.numbers({{site.occupancy, site.b_factor}});
    }
  }
  atoms.note({"alternatives", left_out,
              in_number(left_out, "atom", "atoms") + " on disordered or shared sites left out"});
  atoms.note({"partial_occupancy", partial,
              in_number(partial, "atom", "atoms") + " on sites that are not fully occupied"});
  Particles particles = atoms.finish();
  particles.cell = cell;
  return particles;
}

}  // namespace parray::input
