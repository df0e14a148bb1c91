#include "cli/input/particles/particle_spheres.h"

#include <algorithm>
#include <limits>
#include <numeric>
#include <span>
#include <utility>

#include "cli/input/particles/bonds.h"
#include "cli/input/particles/elements.h"
#include "common/base/bands.h"
#include "common/base/error.h"
#include "common/base/printable.h"
#include "common/base/suggest.h"
#include "common/scene/limits.h"

namespace parray::input {
namespace {

using MaterialRule = ParticleMaterial::Rule;
using RadiusRule = ParticleRadius::Rule;

/// Turns -0 into 0, as in all numbers of a scene file, so that equal scenes have equal bytes.
Vec3d without_negative_zero(const Vec3d& v) { return v + Vec3d{}; }

Material diffuse(const Vec3d& albedo) {
  return {MaterialType::diffuse, without_negative_zero(albedo), 0, 1};
}

/// Frees the memory of a column.
template <typename Column>
void release(Column& column) {
  Column().swap(column);
}

/// Returns the material of a kind of particles. A kind is an atomic number or the number of a type,
/// depending on the rule, or all particles.
/// `type_colors`: see colors_of_names().
Material material_of(std::size_t kind, const Particles& particles, const ParticleMaterial& material,
                     const MaterialNames& names, const std::vector<Vec3d>& type_colors) {
  if (material.rule == MaterialRule::by_element) {
    return diffuse(element(static_cast<std::uint8_t>(kind)).color);
  }
  if (material.rule != MaterialRule::by_type) return *names.find(material.name);
  const Material* named = names.find(particles.types.names[kind]);
  return named != nullptr ? *named : diffuse(type_colors[kind]);
}

/// Returns a material of the type that the rule names, in the given colour.
Material colored_material(const Vec3d& color, const ParticleMaterial& material,
                          const MaterialNames& names) {
  Material out = diffuse(color);
  if (const Material* named = names.find(material.name)) {
    out = *named;
    out.albedo = without_negative_zero(color);
  }
  return out;
}

/// Finds the numbers of the particles' materials, in the order of first use. Looks up each material
/// once.
class MaterialLookup {
 public:
  MaterialLookup(const Particles& particles, const ParticleColors& colors,
                 const ParticleMaterial& material, const MaterialNames& names, MaterialTable& table)
      : particles_(particles),
        colors_(colors),
        material_(material),
        names_(names),
        table_(table),
        type_colors_(colors_of_names(particles.types.names)) {}

  /// Returns false if there are too many materials.
  bool find_all() {
    const std::size_t last = material_.rule == MaterialRule::named ? 1 : particles_.count();
    numbers_.resize(kinds(), unknown);
    for (std::size_t i = 0; i < last; ++i) {
      const std::size_t kind = kind_of(i);
      if (numbers_[kind] != unknown) continue;
      const auto number = table_.intern(of_kind(kind));
      if (!number) return false;
      numbers_[kind] = *number;
    }
    return true;
  }

  /// Returns the number of the particle's material after find_all().
  [[nodiscard]] std::uint32_t operator[](std::size_t particle) const {
    return numbers_[kind_of(particle)];
  }

 private:
  static constexpr std::uint32_t unknown = std::numeric_limits<std::uint32_t>::max();

  [[nodiscard]] std::size_t kinds() const {
    switch (material_.rule) {
      case MaterialRule::by_type: return particles_.types.names.size();
      case MaterialRule::column: return particles_.count();
      case MaterialRule::color_by: return colors_.palette.size();
      default: return 256;  // atomic numbers
    }
  }
  [[nodiscard]] Material of_kind(std::size_t kind) const {
    if (material_.rule == MaterialRule::column) return diffuse(particles_.colors[kind]);
    return material_.rule == MaterialRule::color_by
               ? colored_material(colors_.palette[kind], material_, names_)
               : material_of(kind, particles_, material_, names_, type_colors_);
  }

  /// Returns the kind of a particle. All particles of a kind have the same material.
  [[nodiscard]] std::size_t kind_of(std::size_t particle) const {
    switch (material_.rule) {
      case MaterialRule::by_element: return particles_.elements[particle];
      case MaterialRule::by_type: return particles_.types.index[particle];
      case MaterialRule::column: return particle;
      case MaterialRule::color_by: return colors_.index[particle];
      default: return 0;
    }
  }

  const Particles& particles_;
  const ParticleColors& colors_;
  const ParticleMaterial& material_;
  const MaterialNames& names_;
  MaterialTable& table_;
  std::vector<Vec3d> type_colors_;
  std::vector<std::uint32_t> numbers_;  // by kind
};

/// Returns the radius of an element in the particles' unit of length.
double radius_in_unit(double radius, double angstrom) {
  return std::clamp(radius * angstrom, ranges::length.least, ranges::length.most);
}

/// `angstrom`: its length in the particles' unit.
double radius_of(const Particles& particles, const ParticleRadius& radius, double angstrom,
                 std::size_t particle) {
  switch (radius.rule) {
    case RadiusRule::column: return particles.radii[particle];
    case RadiusRule::by_element:
      return radius_in_unit(element(particles.elements[particle]).radius, angstrom);
    case RadiusRule::covalent:
      return radius_in_unit(crystal_radius(particles.elements[particle]), angstrom);
    default: return radius.value;
  }
}

[[noreturn]] void fail_too_many(const std::string& file, std::uint64_t most,
                                const std::string& what) {
  throw InputError(printable(file, 4096) + ": more than " + std::to_string(most) + what);
}

/// Returns "NAME has no COLUMN: use A, B or OTHERWISE", with the words whose first member is true.
std::string lacks(const std::string& name, std::string_view column,
                  std::initializer_list<std::pair<bool, const char*>> choices,
                  std::string_view otherwise) {
  std::string text = printable(name, 4096) + " has no " + std::string(column) + ": use ";
  std::string separator;
  for (const auto& [supported, word] : choices) {
    if (!supported) continue;
    text += separator + word;
    separator = ", ";
  }
  return text + (separator.empty() ? "" : " or ") + std::string(otherwise);
}

std::string unknown_material(const ParticleMaterial& material, const MaterialNames& materials,
                             std::string_view otherwise) {
  std::span<const std::string_view> words;
  if (material.rule == MaterialRule::named) words = particle_material_words;
  std::string remedy = "write ";
  if (!words.empty()) remedy += list_names(words) + " or ";
  return "unknown material '" + printable(material.name) +
         "': " + materials.remedy_for_undefined(material.name, words, remedy.append(otherwise));
}

}  // namespace

ParticleMaterial decided(const ParticleMaterial& asked, const Particles& particles) {
  if (asked.rule != MaterialRule::automatic) return asked;
  if (!particles.colors.empty()) return {MaterialRule::column, {}};
  if (!particles.elements.empty()) return {MaterialRule::by_element, {}};
  return {particles.types.empty() ? MaterialRule::automatic : MaterialRule::by_type, {}};
}

ParticleRadius decided(const ParticleRadius& asked, const Particles& particles, bool crystal) {
  if (asked.rule != RadiusRule::automatic) return asked;
  if (!particles.radii.empty()) return {RadiusRule::column, 0};
  if (particles.elements.empty()) return {};
  return {crystal ? RadiusRule::covalent : RadiusRule::by_element, 0};
}

std::string problem_with(const ParticleMaterial& material, const Particles& particles,
                         const MaterialNames& materials, const std::string& name,
                         std::string_view otherwise) {
  const auto without = [&](std::string_view column) {
    return lacks(name, column,
                 {{!particles.elements.empty(), "by-element"},
                  {!particles.types.empty(), "by-type"},
                  {!particles.colors.empty(), "column"}},
                 otherwise);
  };
  switch (material.rule) {
    case MaterialRule::named:
      return materials.find(material.name) != nullptr
                 ? ""
                 : unknown_material(material, materials, otherwise);
    case MaterialRule::color_by: {
      const Material* const base = materials.find(material.name);
      if (base == nullptr) {
        return material.name.empty() ? "" : unknown_material(material, materials, otherwise);
      }
      if (base->type != MaterialType::dielectric) return "";
      return "\"color_by\" cannot colour a dielectric (glass): choose a material of another type";
    }
    case MaterialRule::by_element: return particles.elements.empty() ? without("elements") : "";
    case MaterialRule::by_type: return particles.types.empty() ? without("types") : "";
    case MaterialRule::column: return particles.colors.empty() ? without("colours") : "";
    case MaterialRule::automatic: break;
  }
  return without("colours, elements or types");
}

std::string problem_with(const ParticleRadius& radius, const Particles& particles,
                         const std::string& name) {
  const auto without = [&](std::string_view column) {
    return lacks(
        name, column,
        {{!particles.elements.empty(), "by-element"}, {!particles.radii.empty(), "column"}},
        "a number");
  };
  switch (radius.rule) {
    case RadiusRule::fixed: return "";
    case RadiusRule::by_element:
    case RadiusRule::covalent: return particles.elements.empty() ? without("elements") : "";
    case RadiusRule::column: return particles.radii.empty() ? without("radii") : "";
    case RadiusRule::automatic: break;
  }
  return without("radii or elements");
}

Legend legend_of(const Particles& particles, const ParticleMaterial& material,
                 const MaterialNames& materials, const std::vector<std::string>& names) {
  const bool by_element = material.rule == MaterialRule::by_element;
  if (!by_element && material.rule != MaterialRule::by_type) return {};
  std::vector<std::uint64_t> counts(by_element ? last_element + 1U : particles.types.names.size());
  for (std::size_t i = 0; i < particles.count(); ++i) {
    ++counts[by_element ? particles.elements[i] : particles.types.index[i]];
  }
  Legend legend;
  legend.title = by_element ? "element" : "type";
  std::vector<std::size_t> order = reading_order(particles.types.names);
  if (by_element) {
    order.resize(counts.size());
    std::iota(order.begin(), order.end(), std::size_t{0});
    std::rotate(order.begin(), order.begin() + 1, order.end());  // 0 means unknown
  }
  const std::vector<Vec3d> type_colors = colors_of_names(particles.types.names);
  for (const std::size_t kind : order) {
    const auto symbol = element(static_cast<std::uint8_t>(by_element ? kind : 0)).symbol;
    std::string name = !by_element ? particles.types.names[kind]
                       : kind == 0 ? "unknown"
                                   : std::string(symbol);
    if (name.empty()) name = nameless_category;
    if (counts[kind] == 0 && std::ranges::count(names, name) == 0) continue;
    legend.entries.push_back({name,
                              material_of(kind, particles, material, materials, type_colors).albedo,
                              counts[kind]});
  }
  return legend;
}

void append_spheres(Particles particles, const ParticleColors& colors, const ParticleLook& look,
                    const std::string& file, const MaterialNames& materials, Scene& scene,
                    int threads) {
  const std::size_t count = particles.count();
  if (count > limits::max_shapes - scene.spheres.size() - scene.capsules.size()) {
    fail_too_many(file, limits::max_shapes, " spheres in all: split the scene");
  }
  if (count == 0) return;
  if (look.material.rule != MaterialRule::column) release(particles.colors);
  if (look.material.rule != MaterialRule::by_type) particles.types = {};
  if (look.radius.rule != RadiusRule::column) release(particles.radii);
  release(particles.indices);
  MaterialTable table;
  for (const Material& material : scene.materials) {
    table.intern(material);  // gives the same numbers as before
  }
  MaterialLookup surfaces(particles, colors, look.material, materials, table);
  if (!surfaces.find_all()) {
    fail_too_many(file, limits::max_materials,
                  " distinct materials in the scene: round the file's colours");
  }
  const double angstrom = angstrom_of(particles);
  const std::size_t first = scene.spheres.size();
  scene.spheres.resize(first + count);
  Bands(count, threads).run([&](std::size_t /*band*/, std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      scene.spheres[first + i] = {without_negative_zero(particles.positions[i]),
                                  radius_of(particles, look.radius, angstrom, i), surfaces[i]};
    }
  });
  scene.materials = table.take();
}

}  // namespace parray::input
