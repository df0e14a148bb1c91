#include "coordinator/http/guard.h"

#include <arpa/inet.h>

#include <algorithm>
#include <array>
#include <mutex>

#include "common/base/printable.h"
#include "common/base/text.h"

namespace parray::http {
namespace {

/// Returns "localhost" for "localhost:7480" and "::1" for "[::1]:7480".
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

/// Returns "x" for "Bearer x", "" for any other form. The scheme is case-insensitive (RFC 9110,
/// section 11.1).
std::string bearer_token(const std::string& field) {
  constexpr std::string_view scheme = "bearer ";
  if (lower_case(std::string_view(field).substr(0, scheme.size())) != scheme) return "";
  return field.substr(std::min(field.find_first_not_of(' ', scheme.size()), field.size()));
}

}  // namespace

Guard::Guard(const std::filesystem::path& keys, std::vector<std::string> hosts)
    : hosts_(std::move(hosts)) {
  for (std::string& name : hosts_) name = lower_case(name);
  if (!keys.empty()) tokens_ = std::make_unique<TokenList>(keys);
}

void Guard::check_origin(const Request& request) const {
  if (tokens_) return;
  const std::string host = request.field("host");
  if (host.empty()) {
    throw Problem(421, "the header Host is missing: send it with the IP address of this server");
  }
  const std::string name = lower_case(without_port(host));
  if (name != "localhost" && !is_number(name) && std::ranges::count(hosts_, name) == 0) {
    throw Problem(421, "'" + printable(host) +
                           "' is not a name of this server: use its IP address, or start "
                           "parray-coordinator with --http-host " +
                           printable(without_port(host)));
  }
  const std::string& method = request.method;
  if (method == "GET" || method == "HEAD" || method == "OPTIONS") return;
  const std::string origin = request.field("origin");
  const std::size_t scheme = origin.find("://");
  const std::string from = scheme == std::string::npos ? origin : origin.substr(scheme + 3);
  const bool other = (!origin.empty() && lower_case(from) != lower_case(host) &&
                      std::ranges::count(hosts_, lower_case(without_port(from))) == 0) ||
                     request.field("sec-fetch-site") == "cross-site";
  if (other) {
    throw Problem(403, "a page of another site" +
                           (origin.empty() ? "" : ", " + printable(origin) + ",") +
                           " may only read from this server: open the page that this server sends, "
                           "or name the site with --http-host if it is a proxy for this server");
  }
}

Sender Guard::admit(const Request& request) {
  if (!tokens_) return {};
  const std::string token = bearer_token(request.field("authorization"));
  if (token.empty()) {
    throw Problem(401,
                  "a token is missing: send Authorization: Bearer TOKEN, made by parray keygen DIR "
                  "--token NAME",
                  0, {{"WWW-Authenticate", "Bearer realm=\"parray\""}});
  }
  const SteadyClock clock;
  const std::scoped_lock lock(mutex_);
  const auto sender = tokens_->find(clock.now(), token);
  if (!sender) {
    throw Problem(
        401,
        "the token is unknown or no longer valid: make one with parray keygen DIR --token NAME", 0,
        {{"WWW-Authenticate", "Bearer realm=\"parray\", error=\"invalid_token\""}});
  }
  return *sender;
}

}  // namespace parray::http
