#include "cli/input/select/selection.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "cli/input/color/number_bounds.h"
#include "cli/input/particles/elements.h"
#include "cli/input/select/columns.h"
#include "cli/input/select/condition.h"
#include "cli/input/select/text_range.h"
#include "common/base/printable.h"
#include "common/base/suggest.h"
#include "common/base/text.h"

namespace parray::input {
namespace {

using Kind = Expression::Kind;

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
  std::vector<bool> there(last_element + 1U);
  for (const std::uint8_t number : particles.elements) there[number] = true;
  std::vector<std::string> symbols;
  for (std::size_t number = 1; number <= last_element; ++number) {
    if (there[number]) symbols.emplace_back(element(static_cast<std::uint8_t>(number)).symbol);
  }
  if (there[0]) symbols.emplace_back("unknown");
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

Selection::Selection(std::string_view text) : Selection(parse_selection(text)) {}

Selection::Selection(Expression root) : root_(std::move(root)) { collect_numbers(root_, numbers_); }

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
  return mask_of(root_, particles, threads);
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
