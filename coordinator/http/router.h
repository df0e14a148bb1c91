#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "coordinator/http/exchange.h"

namespace parray::http {

/// Finds the function that answers a request.
class Router {
 public:
  /// Which requests the caller of find() may answer: those that Guard::admit() admits, or all.
  enum class Access : std::uint8_t { guarded, open };

  /// Adds a route. `pattern`: "/api/v1/jobs/{id}", where a part in braces stands for any text
  /// without '/' that is not empty. If several patterns fit a path, those with the fewest braces
  /// win. `queries`: names of the permitted query parameters; string literals. GET also answers
  /// HEAD.
  void add(const std::string& method, const std::string& pattern, Answer answer,
           std::vector<std::string_view> queries = {}, Access access = Access::guarded);

  struct Route {
    std::string method;
    std::vector<std::string> parts;  ///< of the pattern, between '/'
    Answer answer;
    std::vector<std::string_view> queries;
    Access access;
  };
  /// The route of a request. Valid until the next add().
  struct Match {
    const Route* route = nullptr;
    std::vector<std::string> arguments;  ///< the parts of the path that stand for {...}
  };
  /// Returns the route of the request. Throws Problem 404 for an unknown path, 405 with the
  /// permitted methods, or 400 for an unknown or repeated query parameter.
  [[nodiscard]] Match find(const Request& request) const;

 private:
  /// Returns the routes of the patterns that fit best.
  [[nodiscard]] std::vector<Match> closest(const std::string& path) const;

  std::vector<Route> routes_;
};

/// Returns the value of `text`: plain decimal digits, from `least` to `most`. Throws Problem 400
/// with `name` in its message.
std::uint64_t whole_number(const std::string& name, const std::string& text, std::uint64_t least,
                           std::uint64_t most);
/// Returns the value of the query parameter `name`, or `fallback` if it is missing. Throws Problem
/// 400.
template <typename Number>
Number number_parameter(const Request& request, const std::string& name, Number least, Number most,
                        Number fallback) {
  const auto found = request.query.find(name);
  if (found == request.query.end()) return fallback;
  return static_cast<Number>(whole_number(name, found->second, least, most));
}

}  // namespace parray::http
