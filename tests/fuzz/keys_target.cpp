#include <sys/stat.h>

#include <algorithm>
#include <fstream>
#include <sstream>

#include "common/base/error.h"
#include "proto/keys.h"
#include "tests/fuzz/target.h"
#include "tests/support/rooms.h"
#include "tests/support/temporary_directory.h"

namespace parray::fuzz {
namespace {

namespace fs = std::filesystem;

// Kinds of files, by an input's first letter.
constexpr char list = 'a';         // allowed
constexpr char coordinator = 'c';  // coordinator.key
constexpr char member = 'm';       // NAME.key

// Any: the seeds are the same everywhere.
constexpr std::string_view one_key = "rq:rM>}U?@Lns47E1%kR.o@n%FcmmsL/@{H8]yf7";
constexpr std::string_view other_key = "JTKVSB%%)wK0E.X)V>+}o?pNmC{O&4W4b!Ni{Lh6";

/// 32 bytes as Z85 (https://rfc.zeromq.org/spec/32).
void promise_key(const std::string& key) {
  constexpr std::string_view z85 =
      "0123456789abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ.-:+=^!/*?&<>()[]{}@%$#";
  promise(key.size() == 40 && key.find_first_not_of(z85) == std::string::npos, "a key of Z85");
}

void write(const fs::path& file, std::string_view text) {
  std::ofstream(file, std::ios::binary) << text;
  promise(chmod(file.c_str(), 0600) == 0, "a file of one's own");
}

/// Names that come and go leave the list as it was.
void promise_editable(const fs::path& directory) {
  constexpr const char* guest = "a-guest-of-the-fuzzer";
  try {
    add_member_key(directory, Role::client, guest);
  } catch (const InputError&) {
    return;  // the name is taken
  }
  const std::string open = read_member_key(directory, guest).own.open;
  AllowList with(directory);
  promise(with.find(Time(0), open).has_value(), "a member that was added");
  remove_member_key(directory, guest);
  AllowList without(directory);
  promise(!without.find(Time(0), open), "a member that was removed");
}

bool run_list(const fs::path& directory, std::string_view text) {
  write(directory / "coordinator.key",
        "public " + std::string(one_key) + "\nsecret " + std::string(other_key) + "\n");
  write(directory / "allowed", text);
  AllowList allowed(directory);
  const auto sender = allowed.find(Time(0), std::string(one_key));
  promise(!sender || !sender->name.empty(), "a member has a name");
  promise(!allowed.find(Time(0), std::string(40, '\0')), "a key that is none");
  promise_editable(directory);
  return true;
}

bool run(std::string_view input) {
  static const test::TemporaryDirectory directory(test::in_memory());
  const fs::path& keys = directory.path();
  try {
    switch (take_letter(input)) {
      case coordinator: {
        write(keys / "coordinator.key", input);
        const KeyPair pair = read_coordinator_key(keys);
        promise_key(pair.open);
        promise_key(pair.secret);
        return true;
      }
      case member: {
        write(keys / "m.key", input);
        const MemberKey key = read_member_key(keys / "m.key", "");
        promise_key(key.coordinator);
        promise_key(key.own.open);
        promise_key(key.own.secret);
        return true;
      }
      default: return run_list(keys, input);
    }
  } catch (const InputError& error) {
    promise_one_line(error.what());
    promise(std::string_view(error.what()).starts_with(keys.string()), "an error with its file");
    return false;
  }
}

std::vector<std::string> seeds() {
  const std::string one(one_key);
  const std::string other(other_key);
  return {
      list +
          ("# who\nworker w " + one + "\nclient ann.b-2_C " + other + "\n\nadmin a " + one + "\n"),
      std::string(1, list), coordinator + ("# ours\npublic " + one + "\nsecret " + other + "\n"),
      member + ("# theirs\ncoordinator " + one + "\npublic " + other + "\nsecret " + one + "\n")};
}

}  // namespace

const Target keys_target{"keys", run, seeds};

}  // namespace parray::fuzz
