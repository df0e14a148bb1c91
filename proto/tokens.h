#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "proto/keys.h"

/// Tokens identify a farm's users over HTTP. DIR, passed as the parameter `directory`, is the
/// directory with the keys of the farm (keys.h). DIR/tokens has one line "NAME SHA-256" per token.
/// A token is 258 random bits, so its hash reveals nothing. "Others" are the group of a file and
/// all other users of its machine.
namespace parray::proto {

/// Returns a new token for the user `name` and writes its hash to DIR/tokens, in place of an older
/// one. The token itself is not stored and cannot be read again. Throws InputError unless
/// DIR/allowed has `name` as a client or an administrator, if others can write the lists, or if
/// DIR/tokens exists and cannot be read. Throws RunError if DIR/tokens cannot be written.
std::string make_token(const std::filesystem::path& directory, const std::string& name);

/// Removes the token of the user `name`. Does nothing if the user has none. Throws InputError if
/// others can write DIR or DIR/tokens, or if DIR/tokens exists and cannot be read. Throws RunError
/// if DIR/tokens cannot be written.
void remove_token(const std::filesystem::path& directory, const std::string& name);

/// Checks DIR/allowed and DIR/tokens. Throws InputError if DIR/allowed cannot be read or has a
/// wrong line, if DIR/tokens exists and cannot be read, or if others can write one of the two files
/// or DIR. (Without this check, a running coordinator would silently continue with the last valid
/// content that it has read.)
void check_key_lists(const std::filesystem::path& directory);

/// The content of DIR/tokens and DIR/allowed. A lookup reads both files again if they were last
/// read a second or more ago. A user who is removed from DIR/allowed has no token either. While
/// others can write a file, DIR/allowed is unusable, or DIR/tokens cannot be read, the content that
/// was read before counts. If DIR/tokens is missing, there are no tokens. Not thread-safe.
class TokenList {
 public:
  /// Throws InputError as check_key_lists() does.
  explicit TokenList(const std::filesystem::path& directory);

  /// Returns the owner of `token`; nothing if no allowed user has it. The call takes equally long
  /// for all wrong tokens, so that its duration does not help to guess one.
  [[nodiscard]] std::optional<Sender> find(Time now, const std::string& token);

 private:
  std::filesystem::path directory_;
  AllowList allowed_;
  Time look_again_at_{};
  std::vector<std::pair<std::string, std::string>> tokens_;  ///< name, SHA-256
};

}  // namespace parray::proto
