#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <string_view>

#include "proto/clock.h"

/// Who may talk to a coordinator beyond its own machine: CURVE keys
/// (https://rfc.zeromq.org/spec/26), 40 characters of Z85 each, in small text files that an
/// administrator can read.
///
///     DIR/coordinator.key   the coordinator's own pair; it never leaves its machine
///     DIR/allowed           who may connect: a line "ROLE NAME PUBLIC-KEY [SHARE]" each
///     DIR/tokens            "NAME SHA-256" of a token each, for HTTP (proto/tokens.h)
///     DIR/NAME.key          what a worker or a person gets: the coordinator's public key, and a
///     pair
///
/// Files with a secret must be closed to others (mode 0600), or they are refused. So are lists, and
/// directories with lists, that others can write: whoever writes them can let anybody in.
namespace parray::proto {

/// What the owner of a key may do.
enum class Role : std::uint8_t {
  none,    ///< nothing: the key is no longer allowed
  worker,  ///< trace
  client,  ///< submit, look, and steer what is one's own
  admin,   ///< all that clients do, with everybody's jobs
  any,     ///< everything: there are no keys
};
std::string_view name_of(Role role);

/// Who a message is from.
struct Sender {
  Role role = Role::any;
  std::string name;       ///< of the key; empty where there are none
  double share = 1;       ///< of the farm, against others' shares
  std::string address{};  ///< of its machine, as this side sees it; empty: unknown
  bool ours = false;      ///< runs on this machine under this process's user: verified
};

/// Name of the key that all workers may share: it tells no machine from another.
inline constexpr const char* shared_worker_key = "worker";

/// Least and largest share that a user may have.
inline constexpr double least_share = 0.001;
inline constexpr double largest_share = 1000;

struct KeyPair {
  std::string open;
  std::string secret;
};
/// Throws RunError where ZeroMQ has no CURVE.
KeyPair make_key_pair();

/// The contents of DIR/NAME.key.
struct MemberKey {
  std::string coordinator;  ///< its public key
  KeyPair own;
};

/// Makes DIR with keys for the coordinator, for all workers (worker.key) and for an administrator
/// (admin.key). Throws InputError when there are some already, RunError when they cannot be
/// written.
void make_farm_keys(const std::filesystem::path& directory);
/// Makes DIR/NAME.key and allows it. `name`: 1 .. 64 letters, digits, '.', '_' and '-'. Throws
/// InputError when there are no farm's keys in DIR or the name is taken, is none or is
/// "coordinator". `share`: least_share .. largest_share.
void add_member_key(const std::filesystem::path& directory, Role role, const std::string& name,
                    double share = 1);
/// Takes NAME off the list: a running coordinator hears no more of that key from the next second
/// on. Throws InputError when it is not on it.
void remove_member_key(const std::filesystem::path& directory, const std::string& name);

/// DIR/coordinator.key. Throws InputError.
KeyPair read_coordinator_key(const std::filesystem::path& directory);
/// Of a file, or, of a directory, of NAME.key in it: whoever has the directory has all. Throws
/// InputError.
MemberKey read_member_key(const std::filesystem::path& path, const std::string& name);

/// Throws InputError with the remedy when group or others can write the file or directory `path`.
/// What is mounted read-only, or is not there, nobody can write.
void refuse_if_others_can_write(const std::filesystem::path& path);

/// DIR/allowed, read again once a second when it is asked. One thread.
class AllowList {
 public:
  /// Throws InputError.
  explicit AllowList(const std::filesystem::path& directory);

  /// Nobody: the key is not on the list. While the file cannot be read or others can write it, what
  /// it said last counts.
  [[nodiscard]] std::optional<Sender> find(Time now, const std::string& open_key);
  /// The same by the key's name.
  [[nodiscard]] std::optional<Sender> find_name(Time now, const std::string& name);

 private:
  void read();
  void read_again(Time now);

  std::filesystem::path file_;
  Time look_again_at_{};
  std::map<std::string, Sender> members_;
};

}  // namespace parray::proto
