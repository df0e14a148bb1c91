#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "proto/clock.h"

/// Keys determine who may talk to a coordinator from other machines. They are CURVE keys
/// (https://rfc.zeromq.org/spec/26), 40 characters of Z85 each, in small text files that an
/// administrator can read.
///
///     DIR/coordinator.key   the coordinator's own pair; it never leaves its machine
///     DIR/allowed           one line "ROLE NAME PUBLIC-KEY [SHARE]" for each allowed key
///     DIR/tokens            one line "NAME SHA-256" for each HTTP token
///     DIR/NAME.key          the file of a worker or a person: the coordinator's public key and
///                           a pair
///
/// The reader refuses a file with a secret unless it is closed to others (mode 0600). It also
/// refuses lists, and directories with lists, that others can write: anyone who can write them can
/// admit anyone. "Others" are the group of a file and all other users of its machine.
///
/// Tokens identify a farm's users over HTTP. A token is 258 random bits, so its hash reveals
/// nothing.
namespace parray::proto {

/// What the owner of a key may do.
enum class Role : std::uint8_t {
  none,    ///< nothing: the key is no longer allowed
  worker,  ///< trace
  client,  ///< submit and look at jobs, control its own jobs
  admin,   ///< everything that clients may do, with all jobs
  any,     ///< everything: the farm has no keys, so the sender is unknown
};
std::string_view name_of(Role role);

/// The sender of a message.
struct Sender {
  Role role = Role::any;
  std::string name;  ///< name of the key; empty without keys
  /// The user's share of the workers' time, relative to other users' shares: least_share to
  /// largest_share.
  double share = 1;
  /// Address of its machine as this side sees it; "localhost" over a socket file, or if ZeroMQ does
  /// not know the address. Empty inside one process.
  std::string address{};
  /// The sender runs on this machine, under this process's user, as the kernel says.
  bool ours = false;
};

/// The name of the key that all workers may share. It does not distinguish machines.
inline constexpr const char* shared_worker_key = "worker";

/// The smallest and largest share of a user.
inline constexpr double least_share = 0.001;
inline constexpr double largest_share = 1000;

struct KeyPair {
  std::string open;    ///< public key
  std::string secret;  ///< secret key
};
/// Makes a pair of keys. Throws RunError if ZeroMQ has no CURVE.
KeyPair make_key_pair();

/// The contents of DIR/NAME.key.
struct MemberKey {
  std::string coordinator;  ///< the coordinator's public key
  KeyPair own;
};

/// Makes DIR with keys for the coordinator, for all workers (worker.key) and for an administrator
/// (admin.key). Throws InputError if DIR has keys, cannot be made, or others can write it. Throws
/// RunError if the keys cannot be made or written.
void make_farm_keys(const std::filesystem::path& directory);
/// Makes DIR/NAME.key and allows the key. `name` has 1 .. 64 letters, digits, '.', '_' and '-', but
/// no '.' first. `share` must be in least_share .. largest_share. Throws InputError if DIR has no
/// keys of a farm, or if the name is taken, invalid or "coordinator"; RunError if it cannot write.
void add_member_key(const std::filesystem::path& directory, Role role, const std::string& name,
                    double share = 1);
/// Removes NAME from DIR/allowed and deletes DIR/NAME.key. A running coordinator refuses messages
/// with that key, and drops workers that use it, from the next second on. Throws InputError if NAME
/// is not in DIR/allowed or the list cannot be used, RunError if it cannot be written.
void remove_member_key(const std::filesystem::path& directory, const std::string& name);

/// Reads DIR/coordinator.key. Throws InputError if the file or DIR cannot be used.
KeyPair read_coordinator_key(const std::filesystem::path& directory);
/// Reads the key file `path`. If `path` is a directory, reads `name`.key in it. Throws InputError
/// if the file cannot be used.
MemberKey read_member_key(const std::filesystem::path& path, const std::string& name);

/// Returns the file that read_member_key() reads.
std::filesystem::path member_key_file(const std::filesystem::path& path, const std::string& name);

/// Throws InputError with the remedy if group or others can write the file or directory `path`.
/// Accepts a path that is mounted read-only or does not exist.
void refuse_if_others_can_write(const std::filesystem::path& path);

/// The content of DIR/allowed. A lookup reads the file again if it was last read a second or more
/// ago. Not thread-safe.
class AllowList {
 public:
  /// Throws InputError if the file cannot be read, has a wrong line, or others can write it or DIR.
  explicit AllowList(const std::filesystem::path& directory);

  /// Returns the owner of a key; nothing if the key is not on the list. While the file cannot be
  /// read, has a wrong line, or others can write it, the content that was read before counts.
  [[nodiscard]] std::optional<Sender> find(Time now, const std::string& open_key);
  /// Does the same as find() for the key with this name.
  [[nodiscard]] std::optional<Sender> find_name(Time now, const std::string& name);

 private:
  void read();

  std::filesystem::path file_;
  Time look_again_at_{};
  std::map<std::string, Sender> members_;
};

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
