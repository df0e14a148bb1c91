#include "cli/input/scene_file/json_syntax_error.h"

#include <algorithm>

#include "common/base/printable.h"

namespace parray::input {
namespace {

/// What follows "syntax error while parsing X - ", without the token and what comes after it.
std::string_view reason_in(std::string_view what) {
  constexpr std::string_view dash = " - ";
  const std::size_t start = what.find(dash, std::min(what.size(), what.find("syntax error")));
  if (start == std::string_view::npos) return "invalid text";
  what.remove_prefix(start + dash.size());
  return what.substr(0, what.find("; last read: '"));
}

/// NaN, Infinity, inf, nan, -Infinity, cut where the lexer gave up.
bool looks_like_infinity_or_nan(std::string_view token) {
  return token.ends_with('N') || token.ends_with('I') || token.ends_with('i') ||
         token.ends_with("na");
}

std::string_view remedy_for(std::string_view reason, std::string_view token) {
  const bool bad_word = reason.starts_with("invalid literal") || reason.starts_with("invalid num");
  if (bad_word && looks_like_infinity_or_nan(token)) {
    return "JSON has no NaN or Infinity, write a finite number";
  }
  if (bad_word && (token.ends_with('/') || token.ends_with('#'))) return "JSON has no comments";
  if (bad_word && token.ends_with('\'')) return "write strings in double quotes";
  if (bad_word && (token.ends_with('\xff') || token.ends_with('\xfe'))) {
    return "it looks like UTF-16, save the file as UTF-8";
  }
  if (bad_word) return "write a number as 0.5 or 1e3, a string in double quotes";
  if (reason.starts_with("unexpected ']'") || reason.starts_with("unexpected '}'")) {
    return "is there a comma too many before it?";
  }
  if (reason.find("UTF-8") != std::string_view::npos) return "save the file as UTF-8";
  return "look for a missing quote, comma or bracket";
}

/// The end of what the lexer read: at most a few words of the line that is wrong.
std::string_view last_words(std::string_view token) {
  constexpr std::string_view line_end = "<U+000A>";  // as the lexer spells it
  constexpr std::size_t most = 24;
  const std::size_t line = token.rfind(line_end);
  if (line != std::string_view::npos && line + line_end.size() < token.size()) {
    token.remove_prefix(line + line_end.size());
  }
  if (token.size() > most) token.remove_prefix(token.size() - most);
  token.remove_prefix(std::min(token.size(), token.find_first_not_of(' ')));
  return token;
}

}  // namespace

std::string describe_syntax_error(std::string_view what, std::string_view last_token) {
  const std::string_view reason = reason_in(what);
  std::string out = "not JSON (" + printable(reason, 200);
  if (what.find("; last read: '") != std::string_view::npos) {
    out += " at '" + printable(last_words(last_token)) + "'";
  }
  out.append("): ").append(remedy_for(reason, last_token));
  return out;
}

}  // namespace parray::input
