#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "proto/keys.h"

/// Tokens identify a farm's users over HTTP. DIR/tokens has one line "NAME SHA-256" per token. A
/// token is 256 random bits, so its hash reveals nothing.
namespace parray::proto {

/// Makes a new token for NAME and replaces the old one; the token cannot be read again later.
/// Throws InputError unless NAME is a client or an administrator of the farm with its keys in
/// `directory`.
std::string make_token(const std::filesystem::path& directory, const std::string& name);

/// Removes the token of NAME if it has one. Throws InputError, RunError.
void remove_token(const std::filesystem::path& directory, const std::string& name);

/// Throws InputError if the lists in DIR cannot be read or others can write them. A running
/// coordinator then uses their last valid content.
void check_key_lists(const std::filesystem::path& directory);

/// The content of DIR/tokens and DIR/allowed. A lookup reads them again if the last reading is a
/// second old. A user who is removed from DIR/allowed has no token either. While others can write a
/// file, its last valid content counts. Not thread-safe.
class TokenList {
 public:
  /// Throws InputError.
  explicit TokenList(const std::filesystem::path& directory);

  /// Returns the owner of the token; nothing if there is none. The time does not depend on the
  /// token.
  [[nodiscard]] std::optional<Sender> find(Time now, const std::string& token);

 private:
  std::filesystem::path directory_;
  AllowList allowed_;
  Time look_again_at_{};
  std::vector<std::pair<std::string, std::string>> tokens_;  ///< name, SHA-256
};

}  // namespace parray::proto
