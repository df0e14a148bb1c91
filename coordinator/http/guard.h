#pragma once

#include <filesystem>
#include <mutex>
#include <string>
#include <vector>

#include "coordinator/http/exchange.h"
#include "proto/tokens.h"

namespace parray::http {

/// Who is let in.
///
/// Without keys whoever reaches the address is trusted, so a web page that somebody here looks at
/// must not pass for them: the host has to be named by number, as localhost, or as one of `hosts`
/// (a name can be made to point here), and what changes something must not come from another site.
/// With keys every request carries a token, which no page of another site has. Any thread.
class Guard {
 public:
  /// `keys`: directory of the farm's keys; empty: there are none. Throws InputError.
  Guard(const std::filesystem::path& keys, std::vector<std::string> hosts);

  [[nodiscard]] bool wants_tokens() const { return !keys_.empty(); }

  /// Throws Problem 421 or 403 where the request comes from another site's page.
  void check_origin(const Request& request) const;
  /// Who asks. Throws Problem 401 or 403.
  [[nodiscard]] Sender admit(const Request& request);

 private:
  [[nodiscard]] bool known_host(const std::string& host) const;

  const std::filesystem::path keys_;
  const std::vector<std::string> hosts_;
  std::mutex mutex_;  // guards tokens_
  std::unique_ptr<TokenList> tokens_;
};

}  // namespace parray::http
