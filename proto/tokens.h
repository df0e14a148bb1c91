#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "proto/keys.h"

/// Tokens stand for a farm's users where they come by HTTP. DIR/tokens has a line "NAME SHA-256"
/// for each: a token is 256 random bits, so its hash tells nobody anything.
namespace parray::proto {

/// A new token for NAME, in place of the one that there was; nobody can read it again. Throws
/// InputError unless NAME is a client or an administrator of the farm whose keys are in
/// `directory`.
std::string make_token(const std::filesystem::path& directory, const std::string& name);

/// NAME has no token any more, if there was one. Throws InputError, RunError.
void remove_token(const std::filesystem::path& directory, const std::string& name);

/// Throws InputError when the lists in DIR cannot be read or others can write them: a running
/// coordinator goes by what they said before.
void check_key_lists(const std::filesystem::path& directory);

/// DIR/tokens and DIR/allowed, read again once a second when it is asked: whoever is taken off the
/// list has no token either. While others can write a file, what it said last counts. One thread.
class TokenList {
 public:
  /// Throws InputError.
  explicit TokenList(const std::filesystem::path& directory);

  /// Whose token it is; nobody's: none. Takes as long whichever it is.
  [[nodiscard]] std::optional<Sender> find(Time now, const std::string& token);

 private:
  std::filesystem::path directory_;
  AllowList allowed_;
  Time look_again_at_{};
  std::vector<std::pair<std::string, std::string>> tokens_;  ///< name, SHA-256
};

}  // namespace parray::proto
