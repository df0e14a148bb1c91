#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <string_view>
#include <vector>

#include "coordinator/http/exchange.h"

namespace parray::http {

/// Which function answers which request.
class Router {
 public:
  /// `arguments`: what stands in the path where the pattern has {...}.
  using Handler = std::function<Reply(const Request&, const std::vector<std::string>& arguments)>;

  /// Who may ask: only those that the guard knows, or anybody.
  enum class Door : std::uint8_t { guarded, open };

  /// `pattern`: "/api/v1/jobs/{id}"; a part in braces stands for any text without '/'. `queries`:
  /// names of parameters that it takes; others are refused. GET answers HEAD, too.
  void add(const std::string& method, const std::string& pattern, Handler handler,
           std::vector<std::string_view> queries = {}, Door door = Door::guarded);

  struct Match {
    const Handler* handler = nullptr;
    std::vector<std::string> arguments;
    Door door = Door::guarded;
  };
  /// Throws Problem: 404, 405 with the methods that there are, 400 for a parameter that it does not
  /// take.
  [[nodiscard]] Match find(const Request& request) const;

 private:
  struct Route {
    std::string method;
    std::vector<std::string> parts;
    Handler handler;
    std::vector<std::string_view> queries;
    Door door;
  };
  std::vector<Route> routes_;
};

/// A whole number in plain decimal digits, `least` to `most`. Throws Problem 400 that names it.
std::uint64_t whole_number(const std::string& name, const std::string& text, std::uint64_t least,
                           std::uint64_t most);
/// That of the parameter `name`, or `fallback` where it is not given. Throws Problem 400.
std::uint64_t number_parameter(const Request& request, const std::string& name, std::uint64_t least,
                               std::uint64_t most, std::uint64_t fallback);

}  // namespace parray::http
