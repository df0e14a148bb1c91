#include "proto/keys.h"

#include <doctest/doctest.h>
#include <sys/stat.h>

#include <filesystem>
#include <fstream>
#include <sstream>

#include "common/base/error.h"
#include "tests/support/message_of.h"
#include "tests/support/rooms.h"
#include "tests/support/temporary_directory.h"

namespace parray::test {
namespace {

namespace fs = std::filesystem;

std::string text_of(const fs::path& file) {
  std::ostringstream text;
  text << std::ifstream(file).rdbuf();
  return text.str();
}

void write(const fs::path& file, const std::string& text) { std::ofstream(file) << text; }

struct Farm {
  Farm() { make_farm_keys(keys); }
  TemporaryDirectory directory;
  fs::path keys = directory.path() / "keys";
};

}  // namespace

TEST_CASE("the keys of a farm fit each other, and other users cannot read their secrets") {
  const Farm farm;
  const KeyPair coordinator = read_coordinator_key(farm.keys);
  AllowList list(farm.keys);
  for (const std::string name : {"worker", "admin"}) {
    const MemberKey member = read_member_key(farm.keys / (name + ".key"), "");
    CHECK(member.coordinator == coordinator.open);
    CHECK(member.own.open.size() == 40);
    CHECK(member.own.secret != coordinator.secret);
    const auto sender = list.find(Time(0), member.own.open);
    REQUIRE(sender);
    CHECK(name_of(sender->role) == name);
    CHECK(sender->name == name);
    CHECK(text_of(farm.keys / "allowed").find(member.own.secret) == std::string::npos);
    // In a directory, the function finds the file of the requested name.
    CHECK(read_member_key(farm.keys, name).own.open == member.own.open);
  }
  for (const char* name : {"coordinator.key", "worker.key", "admin.key"}) {
    CHECK((fs::status(farm.keys / name).permissions() & fs::perms::mask) ==
          (fs::perms::owner_read | fs::perms::owner_write));
  }
  CHECK_FALSE(list.find(Time(0), coordinator.open));
  CHECK_FALSE(list.find(Time(0), make_key_pair().open));
}

TEST_CASE("lists that other users can write are refused, and such directories, too") {
  const auto remedy_of = [](const auto& work) { return message_of<InputError>(work); };
  const auto open_to = [](const fs::path& path, fs::perms perms) {
    fs::permissions(path, perms, fs::perm_options::add);
  };
  for (const fs::perms perms : {fs::perms::group_write, fs::perms::others_write}) {
    const Farm farm;
    make_token(farm.keys, "admin");
    for (const char* name : {"allowed", "tokens", ""}) {
      const fs::path path = *name == 0 ? farm.keys : farm.keys / name;
      open_to(path, perms);
      const std::string remedy = "chmod go-w " + path.string();
      CHECK(remedy_of([&] { check_key_lists(farm.keys); }).find(remedy) != std::string::npos);
      CHECK_THROWS_AS(make_token(farm.keys, "admin"), InputError);
      fs::permissions(path, perms, fs::perm_options::remove);
      check_key_lists(farm.keys);
    }
    open_to(farm.keys, perms);
    CHECK_THROWS_AS(read_coordinator_key(farm.keys), InputError);
    CHECK_THROWS_AS(add_member_key(farm.keys, Role::client, "ann"), InputError);
  }
}

TEST_CASE("a list that other users can write while it is in use admits no new keys") {
  const Farm farm;
  const std::string token = make_token(farm.keys, "admin");
  AllowList list(farm.keys);
  TokenList tokens(farm.keys);
  const std::string admin = read_member_key(farm.keys, "admin").own.open;
  const std::string stranger = make_key_pair().open;
  fs::permissions(farm.keys / "allowed", fs::perms::others_write, fs::perm_options::add);
  fs::permissions(farm.keys / "tokens", fs::perms::others_write, fs::perm_options::add);
  std::ofstream(farm.keys / "allowed", std::ios::app) << "admin me " << stranger << "\n";
  write(farm.keys / "tokens", "");
  CHECK_FALSE(list.find(seconds(5), stranger));
  CHECK(list.find(seconds(5), admin));
  CHECK(tokens.find(seconds(5), token));
}

TEST_CASE("other users cannot read keys, for any umask") {
  const mode_t before = umask(0);
  const Farm farm;
  make_token(farm.keys, "admin");
  umask(before);
  check_key_lists(farm.keys);
}

TEST_CASE("changes of the list take effect within a second") {
  const Farm farm;
  AllowList list(farm.keys);
  CHECK_FALSE(list.find(Time(0), "nobody"));
  add_member_key(farm.keys, Role::client, "ann.b-2_C");
  const std::string ann = read_member_key(farm.keys, "ann.b-2_C").own.open;
  const auto sender = list.find(seconds(1), ann);
  REQUIRE(sender);
  CHECK(sender->role == Role::client);
  CHECK(sender->name == "ann.b-2_C");
  // A removed name may return with another key.
  remove_member_key(farm.keys, "ann.b-2_C");
  CHECK_FALSE(fs::exists(farm.keys / "ann.b-2_C.key"));
  add_member_key(farm.keys, Role::admin, "ann.b-2_C");
  CHECK_FALSE(list.find(seconds(3), ann));
  CHECK(list.find(seconds(3), read_member_key(farm.keys, "ann.b-2_C").own.open)->role ==
        Role::admin);
}

TEST_CASE("a damaged or missing list keeps its last valid content") {
  const Farm farm;
  AllowList list(farm.keys);
  const std::string worker = read_member_key(farm.keys, "worker").own.open;
  const std::string good = text_of(farm.keys / "allowed");
  write(farm.keys / "allowed", "worker w short\n");
  CHECK(list.find(seconds(2), worker));
  CHECK_THROWS_AS(AllowList{farm.keys}, InputError);
  fs::remove(farm.keys / "allowed");
  CHECK(list.find(seconds(4), worker));
  fs::create_directory(farm.keys / "allowed");  // can be opened, but not read
  CHECK(list.find(seconds(5), worker));
  CHECK_THROWS_AS(AllowList{farm.keys}, InputError);
  fs::remove(farm.keys / "allowed");
  write(farm.keys / "allowed", "# nobody\n");
  CHECK_FALSE(list.find(seconds(6), worker));
}

TEST_CASE("a list of tokens that cannot be read is not replaced, and keeps its last content") {
  const Farm farm;
  const fs::path file = farm.keys / "tokens";
  const std::string token = make_token(farm.keys, "admin");
  TokenList tokens(farm.keys);
  fs::rename(file, farm.keys / "kept");
  fs::create_symlink("tokens", file);  // a loop, which not even root can read
  for (const bool is_loop : {true, false}) {
    const auto refusal = [&] {
      return message_of<InputError>([&] { static_cast<void>(make_token(farm.keys, "admin")); });
    };
    CHECK(refusal() == file.string() + " cannot be read: check its owner and its permissions");
    CHECK_THROWS_AS(remove_token(farm.keys, "admin"), InputError);
    CHECK_THROWS_AS(check_key_lists(farm.keys), InputError);
    CHECK(fs::is_symlink(file) == is_loop);
    CHECK(tokens.find(seconds(is_loop ? 2 : 4), token));
    fs::remove(file);
    if (is_loop) fs::create_directory(file);
  }
  CHECK_FALSE(tokens.find(seconds(6), token));  // a missing list has no tokens
  fs::rename(farm.keys / "kept", file);
  CHECK(tokens.find(seconds(8), token));
}

TEST_CASE("invalid key files are refused with the name of the file") {
  const Farm farm;
  const fs::path file = farm.keys / "worker.key";
  const std::string good = text_of(file);
  const auto refusal = [&] {
    return message_of<InputError>([&] { static_cast<void>(read_member_key(file, "")); });
  };
  fs::permissions(file, fs::perms::group_read, fs::perm_options::add);
  CHECK(refusal().find("chmod 600 " + file.string()) != std::string::npos);
  fs::permissions(file, fs::perms::group_read, fs::perm_options::remove);
  CHECK(message_of<InputError>([] { static_cast<void>(read_member_key("/dev/null", "")); }) ==
        "/dev/null is a device and holds no key: name a key file");
  for (const char* name : {"coordinator", "public", "secret"}) {
    std::string bad = good;
    bad.replace(bad.find(std::string("\n") + name + " ") + 1, 3, "xyz");
    write(file, bad);
    CHECK(refusal().find(std::string("has no ") + name + " key") != std::string::npos);
  }
  write(file, good);
  const std::string open = read_member_key(file, "").own.open;
  std::string with_zeros = open;
  with_zeros.replace(5, 3, 3, '\0');  // libzmq would see a shorter key, of 4 bytes
  std::string bad = good;
  write(file, bad.replace(bad.find(open), open.size(), with_zeros));
  CHECK(refusal().find("has no public key") != std::string::npos);
  write(file, "");
  CHECK(refusal().find(file.string()) == 0);
  fs::remove(file);
  CHECK(refusal().find(file.string() + " is missing, or its directory is closed to you") == 0);

  const std::string list = text_of(farm.keys / "allowed");
  write(farm.keys / "allowed", list + "worker w " + with_zeros + "\n");
  CHECK_THROWS_AS(AllowList{farm.keys}, InputError);
  for (const char* line : {"boss b ", "worker ../up ", "worker ", "client a"}) {
    write(farm.keys / "allowed", list + line + "\n");
    CHECK(message_of<InputError>([&] { AllowList{farm.keys}; }).find("allowed:4:") !=
          std::string::npos);
  }
}

TEST_CASE("keys are never overwritten, and names stay within their directory") {
  const Farm farm;
  const std::string before = text_of(farm.keys / "coordinator.key");
  CHECK_THROWS_AS(make_farm_keys(farm.keys), InputError);
  CHECK(text_of(farm.keys / "coordinator.key") == before);
  CHECK_THROWS_AS(add_member_key(farm.keys, Role::client, "worker"), InputError);
  for (const char* name : {"", "..", "../x", "a/b", "a b", "coordinator", ".hidden", "\xc3\xa4"}) {
    CHECK_THROWS_AS(add_member_key(farm.keys, Role::client, name), InputError);
  }
  CHECK_THROWS_AS(add_member_key(farm.keys, Role::client, std::string(65, 'a')), InputError);
  CHECK_THROWS_AS(remove_member_key(farm.keys, "nobody"), InputError);
  CHECK_THROWS_AS(add_member_key(farm.directory.path(), Role::client, "ann"), InputError);
}

}  // namespace parray::test
