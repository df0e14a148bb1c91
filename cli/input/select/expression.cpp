#include "cli/input/select/expression.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <initializer_list>
#include <limits>
#include <optional>
#include <utility>

#include "cli/input/particles/elements.h"
#include "cli/input/select/selection_scanner.h"
#include "common/base/printable.h"
#include "common/base/suggest.h"
#include "common/base/text.h"

namespace parray::input {
namespace {

using Kind = Expression::Kind;

constexpr std::array<std::string_view, 12> class_words{"water",  "protein", "nucleic",  "ion",
                                                       "ions",   "solvent", "hydrogen", "hydrogens",
                                                       "hetero", "ligand",  "backbone", "virtual"};
constexpr std::array<std::string_view, 16> other_words{
    "element", "type", "name", "resname", "chain", "resid", "index", "within",
    "same",    "and",  "or",   "not",     "all",   "none",  "abs",   "sqrt"};

Expression leaf(Kind kind, std::size_t column, std::string word = {}) {
  return {.kind = kind, .column = column, .word = std::move(word)};
}

Expression joined(Kind kind, std::size_t column, std::vector<Expression> parts) {
  Expression out = leaf(kind, column);
  for (const Expression& part : parts) out.depth = std::max(out.depth, part.depth + 1);
  out.parts = std::move(parts);
  return out;
}

std::vector<WholeRange> in_order(std::vector<WholeRange> ranges) {
  std::ranges::sort(ranges, {}, &WholeRange::least);
  std::vector<WholeRange> out;
  for (const WholeRange& range : ranges) {
    if (out.empty() || range.least > out.back().most) {
      out.push_back(range);
    } else {
      out.back().most = std::max(out.back().most, range.most);
    }
  }
  return out;
}

/// Parses "5", "5:9", "5:" or ":9". Returns nothing for other texts and for a range that ends
/// before it begins.
std::optional<WholeRange> whole_range(std::string_view text) {
  using Limits = std::numeric_limits<std::int64_t>;
  const std::size_t colon = text.find(':');
  const std::string_view first = text.substr(0, colon);
  const std::string_view last = colon == std::string_view::npos ? first : text.substr(colon + 1);
  if (first.empty() && last.empty()) return {};
  const auto least = first.empty() ? Limits::min() : parsed<std::int64_t>(first);
  const auto most = last.empty() ? Limits::max() : parsed<std::int64_t>(last);
  if (!least || !most || *least > *most) return {};
  return WholeRange{*least, *most};
}

/// A recursive descent parser with one function for each rule of the grammar.
class SelectionParser {
 public:
  explicit SelectionParser(std::string_view text) : scanner_(text) {
    if (text.size() > max_selection_bytes) {
      scanner_.fail(0, "the selection is longer than " + std::to_string(max_selection_bytes) +
                           " bytes: shorten it");
    }
  }

  Expression parse() {
    Expression out = condition(either());
    if (scanner_.at_end()) return out;
    fail_here(
        "unexpected '" + scanner_.shown(scanner_.next()) + "': " +
        (scanner_.next_is(")") ? "no parenthesis is open" : "join conditions by 'and' or 'or'"));
  }

 private:
  /// Counts how deeply the rules call each other.
  class Level {
   public:
    explicit Level(SelectionParser& parser) : parser_(parser) {
      if (++parser_.level_ > 3 * max_selection_depth) parser_.fail_deep();
    }
    ~Level() { --parser_.level_; }
    Level& operator=(Level&&) = delete;

   private:
    SelectionParser& parser_;
  };

  // Conditions.

  Expression either() {
    const Level level(*this);
    return series(Kind::either, "or", "|", [this] { return both(); });
  }
  Expression both() {
    return series(Kind::both, "and", "&", [this] { return opposite(); });
  }

  /// Parses parts that are separated by the word, or by the sign once or twice.
  Expression series(Kind kind, std::string_view word, std::string_view sign, const auto& part) {
    const std::size_t column = scanner_.column();
    std::vector<Expression> parts;
    parts.push_back(part());
    const std::string twice = std::string(sign).append(sign);
    while (scanner_.take_word(word) || scanner_.take_sign(twice) || scanner_.take_sign(sign)) {
      if (parts.size() == 1) parts.front() = condition(std::move(parts.front()));
      parts.push_back(condition(part()));
    }
    return parts.size() == 1 ? std::move(parts.front()) : made(kind, column, std::move(parts));
  }

  Expression opposite() {
    const Level level(*this);
    const std::size_t column = scanner_.column();
    if (!scanner_.take_word("not") && !scanner_.take_sign("!")) return comparison();
    return made(Kind::opposite, column, condition(opposite()));
  }

  /// A chain such as 10 < z <= 20 holds if all of its comparisons hold.
  Expression comparison() {
    const std::size_t column = scanner_.column();
    Expression left = sum();
    std::vector<Expression> parts;
    for (auto sign = take_comparison(); sign; sign = take_comparison()) {
      left = number(std::move(left));
      Expression right = number(sum());
      parts.push_back(sign->swapped ? made(sign->kind, column, right, std::move(left))
                                    : made(sign->kind, column, std::move(left), right));
      left = std::move(right);
    }
    if (parts.empty()) return left;
    return parts.size() == 1 ? std::move(parts.front())
                             : made(Kind::both, column, std::move(parts));
  }

  struct Comparison {
    Kind kind;
    bool swapped;  ///< true: the right side is the first part
  };
  std::optional<Comparison> take_comparison() {
    static constexpr std::array<std::pair<std::string_view, Comparison>, 7> signs{
        {{"<=", {Kind::less_equal, false}},
         {">=", {Kind::less_equal, true}},
         {"==", {Kind::equal, false}},
         {"!=", {Kind::unequal, false}},
         {"<", {Kind::less, false}},
         {">", {Kind::less, true}},
         {"=", {Kind::equal, false}}}};
    for (const auto& [sign, comparison] : signs) {
      if (scanner_.take_sign(sign)) return comparison;
    }
    return {};
  }

  // Numbers.

  Expression sum() {
    const std::size_t column = scanner_.column();
    Expression left = product();
    for (;;) {
      const bool plus = scanner_.take_sign("+");
      if (!plus && !scanner_.take_sign("-")) return left;
      left = number(std::move(left));
      left = made(plus ? Kind::add : Kind::subtract, column, std::move(left), number(product()));
    }
  }

  Expression product() {
    static constexpr std::array<std::pair<std::string_view, Kind>, 3> signs{
        {{"*", Kind::multiply}, {"/", Kind::divide}, {"%", Kind::remainder}}};
    const std::size_t column = scanner_.column();
    Expression left = factor();
    for (;;) {
      const auto* const sign = std::ranges::find_if(
          signs, [this](const auto& known) { return scanner_.take_sign(known.first); });
      if (sign == signs.end()) return left;
      left = number(std::move(left));
      left = made(sign->second, column, std::move(left), number(factor()));
    }
  }

  Expression factor() {
    const Level level(*this);
    const std::size_t column = scanner_.column();
    if (scanner_.take_sign("-")) return made(Kind::negate, column, number(factor()));
    return primary();
  }

  Expression primary() {
    const std::size_t start = scanner_.next();
    const std::size_t column = scanner_.column();
    if (scanner_.take_sign("(")) {
      Expression out = either();
      if (scanner_.take_sign(")")) return out;
      const std::string open = "the parenthesis at character " + std::to_string(column);
      if (scanner_.at_end()) fail_here(open + " is not closed: add ')'");
      fail_here("unexpected '" + scanner_.shown(scanner_.next()) +
                "': join conditions by 'and' or 'or', or close " + open);
    }
    if (scanner_.next_is_digit()) return constant();
    if (scanner_.next_is("\"")) return leaf(Kind::property, column, lower_case(scanner_.quoted()));
    if (!scanner_.next_is_letter()) fail_without_condition(start);
    const std::string word = scanner_.word();
    if (word == "and" || word == "or" || word == "not") fail_without_condition(start);
    return from_word(word, column);
  }

  Expression constant() {
    Expression out = leaf(Kind::constant, scanner_.column());
    out.number = scanner_.number();
    return out;
  }

  // Rules that begin with a word.

  Expression from_word(const std::string& word, std::size_t column) {
    if (word == "all") return leaf(Kind::all, column);
    if (word == "none") return leaf(Kind::none, column);
    if (word == "element") return elements(column);
    if (word == "type" || word == "name" || word == "resname" || word == "chain") {
      return names(word, column);
    }
    if ((word == "resid" || word == "index") && next_is_range()) return ranges(word, column);
    if (word == "within") return within(column);
    if (word == "same") return same_residue(column);
    if (word == "abs" || word == "sqrt") {
      if (!scanner_.next_is("(")) fail_here("'(' is missing: write " + word + "(x)");
      return made(word == "abs" ? Kind::absolute : Kind::square_root, column, number(primary()));
    }
    const bool is_class = std::ranges::find(class_words, word) != class_words.end();
    return is_class ? class_condition(word, column) : leaf(Kind::property, column, word);
  }

  Expression names(const std::string& word, std::size_t column) {
    Expression out = leaf(Kind::names, column, word);
    while (const auto name = scanner_.name()) out.words.push_back(*name);
    if (out.words.empty()) fail_without_names(word);
    return out;
  }

  Expression elements(std::size_t column) {
    Expression out = leaf(Kind::elements, column);
    for (std::size_t start = scanner_.next(); const auto symbol = scanner_.name();
         start = scanner_.next()) {
      const std::uint8_t number = atomic_number_of(*symbol);
      if (number == 0 && lower_case(*symbol) != "unknown") {
        scanner_.fail(start, "'" + printable(*symbol) +
                                 "' is not an element: write symbols such as C N O, or unknown");
      }
      out.ranges.push_back({number, number});
    }
    if (out.ranges.empty()) fail_without_names("element");
    out.ranges = in_order(std::move(out.ranges));
    return out;
  }

  Expression ranges(const std::string& word, std::size_t column) {
    Expression out = leaf(Kind::ranges, column, word);
    for (std::size_t start = scanner_.next(); const auto text = scanner_.name();
         start = scanner_.next()) {
      const std::optional<WholeRange> range = whole_range(*text);
      if (!range) {
        scanner_.fail(start, "'" + printable(*text) + "' is not a whole number or a range: write " +
                                 word + " 5 10:20");
      }
      out.ranges.push_back(*range);
    }
    out.ranges = in_order(std::move(out.ranges));
    return out;
  }
  bool next_is_range() {
    return scanner_.next_is_digit() || scanner_.next_is("-") || scanner_.next_is(":");
  }

  Expression within(std::size_t column) {
    const std::size_t start = scanner_.next();
    const double distance = scanner_.next_is_digit() ? scanner_.number() : 0;
    if (!(distance > 0)) {
      scanner_.fail(start, "the distance must be above 0: write within 5 of chain A");
    }
    scanner_.expect_word("of", "within 5 of chain A");
    Expression out = made(Kind::within, column, condition(opposite()));
    out.number = distance;
    return out;
  }

  Expression same_residue(std::size_t column) {
    constexpr std::string_view form = "same residue as within 5 of chain A";
    scanner_.expect_word("residue", form);
    scanner_.expect_word("as", form);
    return made(Kind::same_residue, column, condition(opposite()));
  }

  // Construction of expressions.

  template <typename... Parts>
  Expression made(Kind kind, std::size_t column, Parts... parts) {
    std::vector<Expression> list;
    list.reserve(sizeof...(parts));
    (list.push_back(std::move(parts)), ...);
    return made(kind, column, std::move(list));
  }
  Expression made(Kind kind, std::size_t column, std::vector<Expression> parts) {
    Expression out = joined(kind, column, std::move(parts));
    if (out.depth > max_selection_depth) fail_deep();
    return out;
  }

  static Expression condition(Expression expression) {
    if (!expression.is_number()) return expression;
    if (expression.kind == Kind::property) fail_as_condition(expression);
    SelectionScanner::fail_at_column(
        expression.column, "a condition is needed, but this is a number: compare it, as in z > 10");
  }
  static Expression number(Expression expression) {
    if (expression.is_number()) return expression;
    SelectionScanner::fail_at_column(
        expression.column,
        "a number is needed, but this is a condition: compare numbers, as in z > 10");
  }

  // Errors.

  [[noreturn]] static void fail_as_condition(const Expression& property) {
    NearestWord nearest(property.word);
    for (const std::string_view word : class_words) nearest.offer(word);
    for (const std::string_view word : other_words) {
      if (word.size() > 3) nearest.offer(word);  // short words are near many names
    }
    const std::string shown = printable(property.word);
    const bool is_word = std::ranges::all_of(
        shown, [](unsigned char c) { return c == '_' || std::isalnum(c) != 0; });
    const std::string written = is_word ? shown : '"' + shown + '"';
    const bool is_whole = shown == "resid" || shown == "index";
    SelectionScanner::fail_at_column(
        property.column,
        "'" + shown + "' is not a condition: " +
            (is_whole ? "write " + shown + " 5 10:20, or " + shown + " > 5"
             : nearest.best().empty() || nearest.best() == property.word
                 ? "compare it with a number, as in " + written +
                       " > 0, or write chain, resname, name or element before a name"
                 : "did you mean '" + nearest.best() + "'?"));
  }
  [[noreturn]] void fail_without_condition(std::size_t start) {
    const bool end = start == scanner_.next() && scanner_.at_end();
    scanner_.fail(start, "a condition is missing" +
                             (end ? "" : " before '" + scanner_.shown(start) + "'") +
                             ": write one, such as chain A or z > 10");
  }
  [[noreturn]] void fail_without_names(const std::string& word) {
    fail_here("a name is missing after '" + word +
              "': write at least one, in quotes if it has special characters");
  }
  [[noreturn]] void fail_deep() {
    fail_here("nested deeper than " + std::to_string(max_selection_depth) + ": simplify it");
  }
  [[noreturn]] void fail_here(const std::string& problem) {
    scanner_.fail(scanner_.next(), problem);
  }

  SelectionScanner scanner_;
  std::size_t level_ = 0;
};

Expression named(std::string_view word, std::size_t column,
                 std::initializer_list<std::string_view> names) {
  Expression out = leaf(Kind::names, column, std::string(word));
  out.words.assign(names.begin(), names.end());
  return out;
}

}  // namespace

Expression parse_selection(std::string_view text) { return SelectionParser(text).parse(); }

std::span<const std::string_view> selection_classes() { return class_words; }

Expression class_condition(std::string_view word, std::size_t column) {
  const auto is = [column](std::string_view kind) {
    return leaf(Kind::residues, column, std::string(kind));
  };
  const auto together = [column](Kind kind, std::vector<Expression> parts) {
    return joined(kind, column, std::move(parts));
  };
  const auto none_of = [&](std::vector<Expression> parts) {
    return together(Kind::opposite, {together(Kind::either, std::move(parts))});
  };
  if (word == "virtual") return leaf(Kind::sites, column);
  if (word == "ion" || word == "ions") return is("ion");
  if (word == "solvent") return together(Kind::either, {is("water"), is("ion")});
  if (word == "hetero") return none_of({is("protein"), is("nucleic")});
  if (word == "ligand") return none_of({is("protein"), is("nucleic"), is("water"), is("ion")});
  if (word == "hydrogen" || word == "hydrogens") {
    Expression out = leaf(Kind::elements, column);
    out.ranges = {{1, 1}};
    return out;
  }
  if (word == "backbone") {
    return together(
        Kind::either,
        {together(Kind::both, {is("protein"), named("name", column, {"N", "CA", "C", "O", "OXT"})}),
         together(Kind::both, {is("nucleic"), named("name", column,
                                                    {"P", "OP1", "OP2", "OP3", "O1P", "O2P", "O5'",
                                                     "C5'", "C4'", "C3'", "O3'"})})});
  }
  return is(word);
}

}  // namespace parray::input
