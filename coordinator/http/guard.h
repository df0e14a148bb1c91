#pragma once

#include <filesystem>
#include <mutex>
#include <string>
#include <vector>

#include "coordinator/http/exchange.h"
#include "proto/keys.h"

namespace parray::http {

/// Decides which requests are admitted. Callable from any thread.
///
/// Without keys every client that reaches the address is trusted. A foreign web page in a trusted
/// user's browser is not. So Host must be a numeric address, localhost or one of `hosts`, because
/// anyone's DNS can point a name here. Requests that change something must not come from other
/// sites. With keys every request carries a token, which pages of other sites do not have.
class Guard {
 public:
  /// `keys`: directory of the farm's keys; empty: there are no keys. `hosts`: additional host names
  /// of this server. Throws InputError if the lists of tokens cannot be used.
  Guard(const std::filesystem::path& keys, std::vector<std::string> hosts);

  /// Throws Problem 421 if Host is missing or unknown, 403 if a page of another site sent a request
  /// that changes something. Checks nothing if there are keys.
  void check_origin(const Request& request) const;
  /// Returns the sender that the token belongs to; a default Sender if there are no keys. Throws
  /// Problem 401.
  [[nodiscard]] Sender admit(const Request& request);

 private:
  std::vector<std::string> hosts_;     ///< in lower case
  std::mutex mutex_;                   // guards *tokens_
  std::unique_ptr<TokenList> tokens_;  ///< null: requests need no token. Never replaced
};

}  // namespace parray::http
