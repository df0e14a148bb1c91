#include "cli/input/select/selection.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <span>
#include <unordered_map>

#include "cli/input/color/number_bounds.h"
#include "cli/input/color/text_range.h"
#include "cli/input/particles/particle_summary.h"
#include "cli/input/particles/residues.h"
#include "cli/input/select/neighbour_grid.h"
#include "common/base/bands.h"
#include "common/base/printable.h"
#include "common/base/suggest.h"
#include "common/base/text.h"
#include "common/math/real.h"

namespace parray::input {
namespace {

using Kind = Expression::Kind;

/// Returns whether a particle with these names belongs to the class `word`: see class_mask().
bool is_of(std::string_view word, std::string_view residue, std::string_view atom,
           std::uint8_t element) {
  if (word == "water") return is_water(residue);
  if (word == "protein") return is_amino_acid(residue);
  if (word == "nucleic") return is_nucleotide(residue);
  if (word == "ion") return is_ion(residue, atom);
  return is_virtual_site(residue, atom, element);
}

/// Computes the class of each distinct combination of names once and remembers it.
class Answers {
 public:
  Answers(std::string_view word, const Particles& particles) : word_(word), particles_(particles) {}

  bool of(std::size_t i) {
    const NameColumn& residues = particles_.residue_names;
    const NameColumn& atoms = particles_.atom_names;
    const std::uint8_t element = particles_.elements.empty() ? 0 : particles_.elements[i];
    const std::uint64_t key =
        (std::uint64_t{number(residues, i)} << 32U | number(atoms, i)) * 256 + element;
    if (last_ != nullptr && last_->first == key) return last_->second;
    const auto [found, is_new] = answers_.try_emplace(key, false);
    if (is_new) found->second = is_of(word_, name(residues, i), name(atoms, i), element);
    last_ = &*found;
    return found->second;
  }

 private:
  static std::uint32_t number(const NameColumn& column, std::size_t i) {
    return column.empty() ? 0 : column.index[i];
  }
  static std::string_view name(const NameColumn& column, std::size_t i) {
    return column.empty() ? std::string_view() : std::string_view(column.of(i));
  }

  std::string_view word_;
  const Particles& particles_;
  std::unordered_map<std::uint64_t, bool> answers_;
  /// The previous particle's answer: neighbours are often equal.
  const std::pair<const std::uint64_t, bool>* last_ = nullptr;
};

/// Returns whether `text` matches `pattern`. A '*' stands for any number of characters, including
/// none. A ' also stands for the * of old names of nucleic acids: C5' matches C5*.
bool matches(std::string_view pattern, std::string_view text) {
  std::size_t star = std::string_view::npos;
  std::size_t after_star = 0;  // end of the characters that the last star covers, in `text`
  std::size_t p = 0;
  for (std::size_t t = 0; t < text.size();) {
    if (p < pattern.size() && pattern[p] == '*') {
      star = p++;
      after_star = t;
    } else if (p < pattern.size() &&
               (pattern[p] == text[t] || (pattern[p] == '\'' && text[t] == '*'))) {
      ++p;
      ++t;
    } else if (star != std::string_view::npos) {
      p = star + 1;
      t = ++after_star;
    } else {
      return false;
    }
  }
  return pattern.find_first_not_of('*', p) == std::string_view::npos;
}

/// An expression that is bound to the columns of particles. The expression and the particles must
/// outlive this object.
class Condition {
 public:
  Condition(const Expression& expression, const Particles& particles, int threads)
      : expression_(expression), particles_(particles), threads_(threads) {
    parts_.reserve(expression.parts.size());
    for (const Expression& part : expression.parts) parts_.emplace_back(part, particles, threads);
    bind();
  }

  [[nodiscard]] ParticleMask mask() const {
    ParticleMask out(particles_.count());
    Bands(out.size(), threads_).run([&](std::size_t /*band*/, std::size_t begin, std::size_t end) {
      for (std::size_t first = begin; first < end; first += block) {
        holds(first, std::span(out).subspan(first, std::min(block, end - first)));
      }
    });
    return out;
  }

 private:
  /// Number of particles that are evaluated together.
  static constexpr std::size_t block = 256;

  void bind() {
    switch (expression_.kind) {
      case Kind::names: return bind_names();
      case Kind::elements: return bind_elements();
      case Kind::residues:
        if (particles_.residue_names.empty()) fail_without("residue names");
        return bind_class(expression_.word);
      case Kind::sites: return bind_class("virtual");
      case Kind::within: return bind_within();
      case Kind::same_residue: return bind_same_residue();
      case Kind::ranges:
      case Kind::property: return bind_number();
      default: return;
    }
  }

  void bind_number() {
    const std::string& name = expression_.word;
    number_ = number_source(name, particles_);
    if (number_) return;
    if (is_number_column(name)) {
      throw UnknownNumber(name, "character " + std::to_string(expression_.column) + ": ");
    }
    fail_without(name == "resid" ? "residue numbers" : "radii");
  }

  void bind_names() {
    const NameColumn& column = name_column(expression_.word, particles_);
    if (column.empty()) fail_without(plural_of(expression_.word));
    index_ = &column.index;
    for (const std::string& name : column.names) {
      const bool matched = std::ranges::any_of(
          expression_.words, [&](const std::string& pattern) { return matches(pattern, name); });
      table_.push_back(matched ? 1 : 0);
    }
  }

  void bind_class(std::string_view word) {
    mask_ = class_mask(word, particles_);
    if (mask_.empty()) mask_.resize(particles_.count());
  }

  void bind_elements() {
    if (particles_.elements.empty()) fail_without("elements");
    table_.assign(std::numeric_limits<std::uint8_t>::max() + 1, 0);
    for (std::size_t number = 0; number < table_.size(); ++number) {
      table_[number] = in_ranges(static_cast<double>(number)) ? 1 : 0;
    }
  }

  void bind_within() {
    const ParticleMask from = parts_.front().mask();
    std::vector<Vec3d> points;
    for (std::size_t i = 0; i < from.size(); ++i) {
      if (from[i] != 0) points.push_back(particles_.positions[i]);
    }
    const NeighbourGrid grid(points, expression_.number);
    mask_.resize(from.size());
    Bands(from.size(), threads_).run([&](std::size_t /*band*/, std::size_t begin, std::size_t end) {
      for (std::size_t i = begin; i < end; ++i) {
        mask_[i] = from[i] != 0 || grid.near(particles_.positions[i]) ? 1 : 0;
      }
    });
  }

  void bind_same_residue() {
    if (particles_.residue_numbers.empty() && particles_.residue_names.empty()) {
      fail_without("residues");
    }
    mask_ = parts_.front().mask();
    for (std::size_t begin = 0; begin < mask_.size();) {
      std::size_t end = begin + 1;
      while (end < mask_.size() && same_residue(particles_, end, end - 1)) ++end;
      const auto first = mask_.begin() + static_cast<std::ptrdiff_t>(begin);
      const auto last = mask_.begin() + static_cast<std::ptrdiff_t>(end);
      if (std::find(first, last, 1) != last) std::fill(first, last, 1);
      begin = end;
    }
  }

  [[noreturn]] void fail_without(const std::string& what) const {
    const std::size_t column = expression_.column;  // 0: the expression comes from no text
    throw InputError((column == 0 ? "" : "character " + std::to_string(column) + ": ") +
                     "the file has no " + what + ": it has " + columns_of(particles_));
  }

  void holds(std::size_t begin, std::span<std::uint8_t> out) const {
    const auto each = [&](const auto& holds_for) {
      for (std::size_t i = 0; i < out.size(); ++i) out[i] = holds_for(begin + i) ? 1 : 0;
    };
    switch (expression_.kind) {
      case Kind::all: return each([](std::size_t) { return true; });
      case Kind::none: return each([](std::size_t) { return false; });
      case Kind::both:
      case Kind::either: {
        const bool both = expression_.kind == Kind::both;
        parts_.front().holds(begin, out);
        std::array<std::uint8_t, block> more{};
        for (std::size_t part = 1; part < parts_.size(); ++part) {
          parts_[part].holds(begin, std::span(more).first(out.size()));
          for (std::size_t i = 0; i < out.size(); ++i) {
            out[i] = both ? out[i] & more[i] : out[i] | more[i];
          }
        }
        return;
      }
      case Kind::opposite:
        parts_.front().holds(begin, out);
        for (std::uint8_t& value : out) value ^= 1U;
        return;
      case Kind::names: return each([&](std::size_t i) { return table_[(*index_)[i]] != 0; });
      case Kind::elements:
        return each([&](std::size_t i) { return table_[particles_.elements[i]] != 0; });
      case Kind::ranges: {
        std::array<double, block> values{};
        number_(begin, std::span(values).first(out.size()));
        return each([&](std::size_t i) { return in_ranges(values[i - begin]); });
      }
      case Kind::residues:
      case Kind::sites:
      case Kind::within:
      case Kind::same_residue: return each([&](std::size_t i) { return mask_[i] != 0; });
      default: return compare(begin, out);
    }
  }

  void compare(std::size_t begin, std::span<std::uint8_t> out) const {
    std::array<double, block> left{};
    std::array<double, block> right{};
    parts_[0].numbers(begin, std::span(left).first(out.size()));
    parts_[1].numbers(begin, std::span(right).first(out.size()));
    const auto each = [&](const auto& holds_for) {
      for (std::size_t i = 0; i < out.size(); ++i) out[i] = holds_for(left[i], right[i]) ? 1 : 0;
    };
    switch (expression_.kind) {
      case Kind::less: return each([](double a, double b) { return a < b; });
      case Kind::less_equal: return each([](double a, double b) { return a <= b; });
      case Kind::equal: return each([](double a, double b) { return a == b; });
      default: return each([](double a, double b) { return a < b || a > b; });
    }
  }

  void numbers(std::size_t begin, std::span<double> out) const {
    if (expression_.kind == Kind::property) return number_(begin, out);
    if (expression_.kind == Kind::constant) {
      std::ranges::fill(out, expression_.number);
      return;
    }
    parts_.front().numbers(begin, out);
    std::array<double, block> right{};
    if (parts_.size() > 1) parts_[1].numbers(begin, std::span(right).first(out.size()));
    const auto each = [&](const auto& result) {
      for (std::size_t i = 0; i < out.size(); ++i) out[i] = result(out[i], right[i]);
    };
    switch (expression_.kind) {
      case Kind::add: return each([](double a, double b) { return a + b; });
      case Kind::subtract: return each([](double a, double b) { return a - b; });
      case Kind::multiply: return each([](double a, double b) { return a * b; });
      case Kind::divide: return each([](double a, double b) { return a / b; });
      case Kind::remainder: return each([](double a, double b) { return std::fmod(a, b); });
      case Kind::negate: return each([](double a, double /*b*/) { return -a; });
      case Kind::absolute: return each([](double a, double /*b*/) { return std::abs(a); });
      default: return each([](double a, double /*b*/) { return square_root(a); });
    }
  }

  [[nodiscard]] bool in_ranges(double number) const {
    const auto& ranges = expression_.ranges;
    const auto after = std::ranges::upper_bound(ranges, number, {}, [](const WholeRange& range) {
      return static_cast<double>(range.least);
    });
    return after != ranges.begin() && number <= static_cast<double>(std::prev(after)->most);
  }

  const Expression& expression_;
  const Particles& particles_;
  int threads_;
  std::vector<Condition> parts_;
  NumberSource number_;
  const std::vector<std::uint32_t>* index_ = nullptr;  // of names: places in `table_`
  std::vector<std::uint8_t> table_;  // 1 for each entry that satisfies the condition
  ParticleMask mask_;  // of all particles; empty if the condition is evaluated in blocks
};

void collect_numbers(const Expression& expression, std::set<std::string, std::less<>>& numbers) {
  if (expression.kind == Kind::property && is_requested_column(expression.word)) {
    numbers.insert(expression.word);
  }
  for (const Expression& part : expression.parts) collect_numbers(part, numbers);
}

/// Returns at most ten names: "A, B, C and 5 more".
std::string some_of(const std::vector<std::string>& names) {
  constexpr std::size_t most = 10;
  std::string text;
  for (std::size_t i = 0; i < std::min(names.size(), most); ++i) {
    text += (i == 0 ? "" : ", ") + (names[i].empty() ? "\"\"" : printable(names[i], 20));
  }
  if (names.size() > most) text += " and " + std::to_string(names.size() - most) + " more";
  return text;
}

std::vector<std::string> symbols_of(const Particles& particles) {
  std::vector<std::string> symbols;
  for (const auto& [symbol, count] : element_counts(particles.elements)) symbols.push_back(symbol);
  return symbols;
}

/// Returns "z from 0 to 31.5". Returns "" if no number is known.
std::string extent_of(const std::string& name, const Particles& particles) {
  const NumberSource source = number_source(name, particles);
  if (!source) return {};
  NumberBounds bounds;
  for (std::size_t i = 0; i < particles.count(); ++i) {
    double value = 0;
    source(i, {&value, 1});
    if (std::isfinite(value)) bounds.add(value);
  }
  if (bounds.empty()) return {};
  return printable(name) + " from " + number_text(bounds.low) + " to " + number_text(bounds.high);
}

/// Adds to `texts` the values that the particles have for each leaf of an expression, without
/// repetition.
void describe(const Expression& expression, const Particles& particles,
              std::vector<std::string>& texts) {
  std::string text;
  if (expression.kind == Kind::names || expression.kind == Kind::residues) {
    const std::string word = expression.kind == Kind::names ? expression.word : "resname";
    const NameColumn& column = name_column(word, particles);
    if (!column.empty()) text = plural_of(word) + " " + some_of(column.names);
  } else if (expression.kind == Kind::elements) {
    text = "elements " + some_of(symbols_of(particles));
  } else if (expression.kind == Kind::property || expression.kind == Kind::ranges) {
    text = extent_of(expression.word, particles);
  }
  if (!text.empty() && std::ranges::find(texts, text) == texts.end()) texts.push_back(text);
  for (const Expression& part : expression.parts) describe(part, particles, texts);
}

[[noreturn]] void fail_slice(std::string_view part) {
  throw InputError("'" + printable(part) +
                   "' is not a slice: write z=10:20, or z=40%:60% for a part of the cell");
}

/// Returns a comparison with one end of a slice: "fz >= 0.4" for 40% of z.
std::string compared(const RangeEnd& end, const char* sign, char axis) {
  return std::string(end.percent ? "f" : "") + axis + " " + sign + " " +
         number_text(end.percent ? end.value / 100 : end.value);
}

}  // namespace

UnknownNumber::UnknownNumber(std::string name, const std::string& place)
    : InputError(place + "the file has no numeric column '" + printable(name) + "'"),
      name_(std::move(name)) {}

std::string UnknownNumber::with_remedy(const std::vector<std::string>& known) const {
  const std::vector<std::string_view> names(known.begin(), known.end());
  return std::string(what()) + ": " + remedy_for_name(name_, names);
}

NumberSource known_number(const char* key, const std::string& name, const Particles& particles) {
  NumberSource source = number_source(name, particles);
  if (source) return source;
  if (is_number_column(name)) throw UnknownNumber(name);
  throw SourceError(key, "the file has no " + printable(name) + " column");
}

Selection::Selection(std::string_view text) : Selection(parse_selection(text)) {}

std::set<std::string, std::less<>> Selection::numbers() const {
  std::set<std::string, std::less<>> numbers;
  collect_numbers(root_, numbers);
  return numbers;
}

Selection Selection::any_of(const std::vector<std::string>& classes) {
  Expression root;
  root.kind = Kind::either;
  for (const std::string& word : classes) {
    if (std::ranges::find(selection_classes(), word) == selection_classes().end()) {
      throw InputError("'" + printable(word) + "' is not a class of particles: " +
                       remedy_for_name(word, selection_classes()));
    }
    root.parts.push_back(class_condition(word, 0));
  }
  if (root.parts.empty()) root.kind = Kind::none;
  return Selection(std::move(root));
}

ParticleMask Selection::mask(const Particles& particles, int threads) const {
  return Condition(root_, particles, threads).mask();
}

ParticleMask Selection::some(const Particles& particles, int threads, const std::string& problem,
                             const char* otherwise) const {
  ParticleMask selected = mask(particles, threads);
  if (std::ranges::find(selected, 1) != selected.end()) return selected;
  const std::string there_is = what_there_is(particles);
  throw InputError(problem + (there_is.empty() ? otherwise : there_is));
}

std::string Selection::what_there_is(const Particles& particles) const {
  std::vector<std::string> texts;
  describe(root_, particles, texts);
  return texts.empty() ? "" : "there are " + base::joined(texts, "; ");
}

ParticleMask class_mask(std::string_view word, const Particles& particles) {
  if (particles.residue_names.empty() && particles.atom_names.empty()) return {};
  Answers answers(word, particles);
  ParticleMask mask;
  for (std::size_t i = 0; i < particles.count(); ++i) {
    if (!answers.of(i)) continue;
    if (mask.empty()) mask.resize(particles.count());
    mask[i] = 1;
  }
  return mask;
}

std::string slice_as_selection(std::string_view text) {
  std::string out;
  for (std::string_view part : split_at(',', text)) {
    part = trimmed(part);
    const std::size_t equals = std::min(part.find('='), part.size());
    const std::string axis = lower_case(trimmed(part.substr(0, equals)));
    const auto range = text_range(part.substr(std::min(equals + 1, part.size())));
    if (axis.size() != 1 || axis < "x" || axis > "z" || !range) fail_slice(part);
    if (range->low && range->high && range->low->percent != range->high->percent) {
      throw InputError("'" + printable(part) + "': only one end is a percentage: write z=40%:60% " +
                       "for a part of the cell, or two lengths");
    }
    if (range->low) out += (out.empty() ? "" : " and ") + compared(*range->low, ">=", axis[0]);
    if (range->high) out += (out.empty() ? "" : " and ") + compared(*range->high, "<=", axis[0]);
  }
  return out;
}

}  // namespace parray::input
