#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "coordinator/http/exchange.h"

namespace parray::http {

/// Finds the function that answers a request.
class Router {
 public:
  /// Answers a request. `arguments`: the parts of the path that stand for {...} in the pattern.
  using Handler = std::function<Reply(const Request&, const std::vector<std::string>& arguments)>;

  /// Which requests the caller of find() may answer: those that Guard::admit() admits, or all.
  enum class Access : std::uint8_t { guarded, open };

  /// Adds a route. `pattern`: "/api/v1/jobs/{id}", where a part in braces stands for any text
  /// without '/' that is not empty. If several patterns fit a path, those with the fewest braces
  /// win. `queries`: names of the permitted query parameters; string literals. GET also answers
  /// HEAD.
  void add(const std::string& method, const std::string& pattern, Handler handler,
           std::vector<std::string_view> queries = {}, Access access = Access::guarded);

  /// The route of a request.
  struct Match {
    const Handler* handler = nullptr;
    std::vector<std::string> arguments;
    Access access = Access::guarded;
  };
  /// Returns the route of the request. Throws Problem 404 for an unknown path, 405 with the
  /// permitted methods, or 400 for an unknown or repeated query parameter.
  [[nodiscard]] Match find(const Request& request) const;

 private:
  struct Route {
    std::string method;
    std::vector<std::string> parts;
    Handler handler;
    std::vector<std::string_view> queries;
    Access access;
  };
  /// Returns the routes of the patterns that fit best, with their arguments.
  [[nodiscard]] std::vector<std::pair<const Route*, std::vector<std::string>>> closest(
      const std::vector<std::string>& parts) const;

  std::vector<Route> routes_;
};

/// Returns the value of `text`: plain decimal digits, from `least` to `most`. Throws Problem 400
/// with `name` in its message.
std::uint64_t whole_number(const std::string& name, const std::string& text, std::uint64_t least,
                           std::uint64_t most);
/// Returns the value of the query parameter `name`, or `fallback` if it is missing. Throws Problem
/// 400.
std::uint64_t number_parameter(const Request& request, const std::string& name, std::uint64_t least,
                               std::uint64_t most, std::uint64_t fallback);

}  // namespace parray::http
