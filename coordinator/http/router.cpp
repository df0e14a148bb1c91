#include "coordinator/http/router.h"

#include <algorithm>
#include <optional>

#include "common/base/printable.h"
#include "common/base/suggest.h"
#include "common/base/text.h"

namespace parray::http {
namespace {

/// Returns the parts behind the first '/'.
std::vector<std::string_view> parts_of(std::string_view path) {
  if (path.empty()) return {};
  return split_at('/', path.substr(1));
}

std::optional<std::vector<std::string>> match(const std::vector<std::string>& pattern,
                                              const std::vector<std::string_view>& parts) {
  if (pattern.size() != parts.size()) return {};
  std::vector<std::string> arguments;
  for (std::size_t i = 0; i < parts.size(); ++i) {
    if (pattern[i].starts_with('{') && !parts[i].empty()) {
      arguments.emplace_back(parts[i]);
    } else if (pattern[i] != parts[i]) {
      return {};
    }
  }
  return arguments;
}

void check_parameters(const Request& request, const std::vector<std::string_view>& known) {
  for (const auto& [name, value] : request.query) {
    if (std::ranges::find(known, name) == known.end()) {
      throw Problem(400, "unknown parameter '" + printable(name) + "': " +
                             (known.empty() ? "this path has none" : remedy_for_name(name, known)));
    }
    if (request.query.count(name) > 1) {
      throw Problem(400, "parameter '" + name + "' occurs twice: send it once");
    }
  }
}

}  // namespace

void Router::add(const std::string& method, const std::string& pattern, Answer answer,
                 std::vector<std::string_view> queries, Access access) {
  const std::vector<std::string_view> parts = parts_of(pattern);
  routes_.push_back({method, std::vector<std::string>(parts.begin(), parts.end()),
                     std::move(answer), std::move(queries), access});
}

std::vector<Router::Match> Router::closest(const std::string& path) const {
  const std::vector<std::string_view> parts = parts_of(path);
  std::vector<Match> found;
  for (const Route& route : routes_) {
    auto arguments = match(route.parts, parts);
    if (!arguments) continue;
    if (!found.empty() && arguments->size() < found.front().arguments.size()) found.clear();
    if (!found.empty() && arguments->size() > found.front().arguments.size()) continue;
    found.push_back({&route, *std::move(arguments)});
  }
  return found;
}

Router::Match Router::find(const Request& request) const {
  const std::string method = request.method == "HEAD" ? "GET" : request.method;
  std::string others;
  for (Match& match : closest(request.path)) {
    if (match.route->method == method) {
      check_parameters(request, match.route->queries);
      return std::move(match);
    }
    others += (others.empty() ? "" : ", ") + match.route->method;
  }
  if (!others.empty()) {
    throw Problem(405,
                  printable(request.path, 200) + " does not support " + printable(request.method) +
                      ": use " + others,
                  0, {{"Allow", others}});
  }
  throw Problem(404, printable(request.path, 200) +
                         " does not exist: see /api/v1/openapi.json for the paths");
}

std::uint64_t whole_number(const std::string& name, const std::string& text, std::uint64_t least,
                           std::uint64_t most) {
  const std::optional<std::uint64_t> value = parsed_between(text, least, most);
  if (!value) {
    throw Problem(400,
                  name + ": '" + printable(text) + "' is not a whole number from " +
                      std::to_string(least) + " to " + std::to_string(most),
                  2);
  }
  return *value;
}

}  // namespace parray::http
