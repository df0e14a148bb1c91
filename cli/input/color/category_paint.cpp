#include "cli/input/color/category_paint.h"

#include <algorithm>
#include <numeric>

#include "cli/input/color/category_colors.h"
#include "cli/input/color/residue_groups.h"
#include "cli/input/particles/elements.h"
#include "cli/input/particles/particle_text.h"
#include "cli/input/particles/source_error.h"
#include "cli/input/select/column_names.h"

namespace parray::input {
namespace {

/// A category that some particles may belong to.
struct Category {
  std::string name;
  Vec3d color;
};

/// `index`: the category of each particle. Entries of the legend are in the order `reading` of the
/// categories; those without particles are left out.
ParticlePaint paint_of(std::string title, const std::vector<Category>& categories,
                       std::vector<std::uint32_t> index, const std::vector<std::size_t>& reading) {
  ParticlePaint paint;
  std::vector<std::uint64_t> counts(categories.size());
  for (const std::uint32_t category : index) ++counts[category];
  for (const Category& category : categories) paint.colors.push_back(category.color);
  paint.index = std::move(index);
  paint.legend.title = std::move(title);
  for (const std::size_t i : reading) {
    if (counts[i] == 0) continue;
    const std::string& name = categories[i].name;
    paint.legend.entries.push_back(
        {name.empty() ? "no name" : name, categories[i].color, counts[i]});
  }
  return paint;
}

std::vector<std::size_t> as_they_come(std::size_t count) {
  std::vector<std::size_t> order(count);
  std::iota(order.begin(), order.end(), std::size_t{0});
  return order;
}

ParticlePaint by_element(const Particles& particles) {
  std::vector<Category> categories;
  for (std::size_t number = 0; number <= last_element; ++number) {
    const Element& entry = element(static_cast<std::uint8_t>(number));
    categories.push_back({number == 0 ? "unknown" : std::string(entry.symbol), entry.color});
  }
  std::vector<std::size_t> reading = as_they_come(categories.size());
  std::rotate(reading.begin(), reading.begin() + 1, reading.end());  // unknown last
  return paint_of("element", categories, {particles.elements.begin(), particles.elements.end()},
                  reading);
}

/// Numbers by value, before texts by their letters; without a name last.
bool reads_before(const std::string& a, const std::string& b) {
  if (a.empty() != b.empty()) return b.empty();
  const std::optional<double> number_a = number_in(a);
  const std::optional<double> number_b = number_in(b);
  if (number_a && number_b && *number_a != *number_b) return *number_a < *number_b;
  if (number_a.has_value() != number_b.has_value()) return number_a.has_value();
  return a < b;
}

/// In reading order, so that a name has its colour whichever particle comes first: frames of a
/// trajectory may have them in any order.
ParticlePaint by_name(std::string title, const NameColumn& column) {
  std::vector<std::size_t> reading = as_they_come(column.names.size());
  std::ranges::sort(reading, [&](std::size_t a, std::size_t b) {
    return reads_before(column.names[a], column.names[b]);
  });
  std::vector<Category> categories(column.names.size());
  for (std::size_t i = 0; i < reading.size(); ++i) {
    categories[reading[i]] = {column.names[reading[i]], category_color(i)};
  }
  return paint_of(std::move(title), categories, column.index, reading);
}

/// Residues of no group are categories of their own.
ParticlePaint by_residue(const NameColumn& column) {
  std::vector<Category> categories;
  for (const std::string_view group : residue_groups()) {
    categories.push_back({std::string(group), category_color(categories.size())});
  }
  std::vector<std::uint32_t> category_of;
  for (const std::string& name : column.names) {
    const std::optional<std::size_t> group = residue_group(name);
    category_of.push_back(static_cast<std::uint32_t>(group.value_or(categories.size())));
    if (!group) categories.push_back({name, category_color(categories.size())});
  }
  std::vector<std::uint32_t> index(column.index.size());
  std::ranges::transform(column.index, index.begin(),
                         [&](std::uint32_t name) { return category_of[name]; });
  return paint_of("residue", categories, std::move(index), as_they_come(categories.size()));
}

}  // namespace

ParticlePaint painted_by_category(std::string_view word, const Particles& particles) {
  const auto check = [&](bool there, const std::string& what) {
    if (!there) {
      throw SourceError("color_by",
                        "the file has no " + what + ": it has " + columns_of(particles));
    }
  };
  if (word == "element") {
    check(!particles.elements.empty(), "elements");
    return by_element(particles);
  }
  const std::string_view column_word =
      word == "residue" ? "resname" : (word == "atom" ? "name" : word);
  const NameColumn& column = name_column(column_word, particles);
  check(!column.empty(), plural_of(column_word));
  return word == "residue" ? by_residue(column) : by_name(std::string(word), column);
}

}  // namespace parray::input
