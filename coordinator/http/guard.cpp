#include "coordinator/http/guard.h"

#include <arpa/inet.h>

#include <algorithm>
#include <array>
#include <mutex>

#include "common/base/printable.h"

namespace parray::http {
namespace {

/// "localhost" of "localhost:7480", "::1" of "[::1]:7480".
std::string without_port(const std::string& host) {
  const std::size_t bracket = host.find(']');
  if (host.starts_with('[') && bracket != std::string::npos) return host.substr(1, bracket - 1);
  return host.substr(0, host.find(':'));
}

bool is_number(const std::string& host) {
  std::array<unsigned char, sizeof(in6_addr)> address{};
  return inet_pton(AF_INET, host.c_str(), address.data()) == 1 ||
         inet_pton(AF_INET6, host.c_str(), address.data()) == 1;
}

bool changes_something(const Request& request) {
  return request.method != "GET" && request.method != "HEAD" && request.method != "OPTIONS";
}

}  // namespace

Guard::Guard(const std::filesystem::path& keys, std::vector<std::string> hosts)
    : keys_(keys), hosts_(std::move(hosts)) {
  if (wants_tokens()) tokens_ = std::make_unique<TokenList>(keys);
}

bool Guard::known_host(const std::string& host) const {
  const std::string name = without_port(host);
  return name == "localhost" || is_number(name) || std::ranges::find(hosts_, name) != hosts_.end();
}

void Guard::check_origin(const Request& request) const {
  if (wants_tokens()) return;
  const std::string host = request.field("host");
  if (!known_host(host)) {
    throw Problem(421, "this server is not '" + printable(host) +
                           "': use its address in digits, or start it with --http-host " +
                           printable(without_port(host)));
  }
  if (!changes_something(request)) return;
  const std::string origin = request.field("origin");
  const std::size_t scheme = origin.find("://");
  const std::string from = scheme == std::string::npos ? origin : origin.substr(scheme + 3);
  const bool other =
      (!origin.empty() && from != host && std::ranges::count(hosts_, without_port(from)) == 0) ||
      request.field("sec-fetch-site") == "cross-site";
  if (other) {
    throw Problem(403, "a page of another site, " + printable(origin) + ", may not ask this");
  }
}

Sender Guard::admit(const Request& request) {
  if (!wants_tokens()) return {};
  constexpr std::string_view scheme = "Bearer ";
  const std::string given = request.field("authorization");
  if (!given.starts_with(scheme)) {
    throw Problem(401,
                  "a token is needed: Authorization: Bearer TOKEN, made by parray keygen DIR "
                  "--token NAME",
                  0, {{"WWW-Authenticate", "Bearer realm=\"parray\""}});
  }
  const SteadyClock clock;
  const std::scoped_lock lock(mutex_);
  const auto sender = tokens_->find(clock.now(), given.substr(scheme.size()));
  if (!sender) {
    throw Problem(401, "this token is not known, or no longer", 0,
                  {{"WWW-Authenticate", "Bearer realm=\"parray\", error=\"invalid_token\""}});
  }
  return *sender;
}

}  // namespace parray::http
