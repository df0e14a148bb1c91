#include "proto/keys.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <sys/statvfs.h>
#include <unistd.h>
#include <zmq.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <random>
#include <span>
#include <sstream>
#include <system_error>

#include "common/base/ascii.h"
#include "common/base/error.h"
#include "common/base/files.h"
#include "common/base/sha256.h"

namespace parray::proto {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t key_length = 40;
constexpr std::array roles = {Role::worker, Role::client, Role::admin};

bool is_key(const std::string& text) {
  std::array<std::uint8_t, 32> raw{};
  const bool whole = text.find('\0') == std::string::npos;  // libzmq ends the text at a zero byte
  return text.size() == key_length && whole && zmq_z85_decode(raw.data(), text.c_str()) != nullptr;
}

bool is_name(const std::string& text) {
  return !text.empty() && text.size() <= 64 && text.front() != '.' &&
         std::ranges::all_of(text, [](char c) {
           return ascii::is_letter_or_digit(c) || c == '.' || c == '_' || c == '-';
         });
}

[[noreturn]] void fail_writing(const fs::path& file) {
  throw RunError("writing " + file.string() + " failed: " + std::generic_category().message(errno));
}

/// Writes a file. With `fresh`, throws InputError if the file exists; otherwise replaces it.
void write_key_file(const fs::path& file, const std::string& text, mode_t mode, bool fresh) {
  const fs::path made = fresh ? file : fs::path(file.string() + ".new");
  const int out =
      open(made.c_str(), O_WRONLY | O_CREAT | O_CLOEXEC | (fresh ? O_EXCL : O_TRUNC), mode);
  if (out < 0) {
    if (errno == EEXIST) {
      throw InputError(file.string() + " already exists: use another directory or name");
    }
    fail_writing(file);
  }
  const bool done = write(out, text.data(), text.size()) == static_cast<ssize_t>(text.size()) &&
                    fsync(out) == 0 && (fresh || rename(made.c_str(), file.c_str()) == 0);
  const int error = errno;
  close(out);
  if (!done) {
    unlink(made.c_str());
    errno = error;
    fail_writing(file);
  }
}

std::string key_text(const fs::path& file) {
  std::optional<std::string> text = read_file(file);
  if (!text) {
    if (access(file.c_str(), F_OK) == 0) {
      throw InputError(file.string() + " cannot be read: check its owner and its permissions");
    }
    throw InputError(
        file.string() +
        " is missing, or its directory is closed to you: check the path, or make keys with "
        "parray keygen");
  }
  return *std::move(text);
}

/// Reads values by name from lines "NAME VALUE"; lines that begin with "# " are comments.
std::map<std::string, std::string> read_secret_file(const fs::path& file) {
  const std::string text = key_text(file);
  struct stat found {};
  const bool there = stat(file.c_str(), &found) == 0;
  if (there && (S_ISCHR(found.st_mode) || S_ISBLK(found.st_mode))) {
    throw InputError(file.string() + " is a device and holds no key: name a key file");
  }
  if (!there || (found.st_mode & 077) != 0) {
    throw InputError(file.string() +
                     " holds a secret that others on this machine can read: chmod 600 " +
                     file.string());
  }
  std::map<std::string, std::string> values;
  std::istringstream lines(text);
  for (std::string line; std::getline(lines, line);) {
    std::istringstream words(line);
    std::string name;
    std::string value;
    if (!line.starts_with("# ") && words >> name >> value) values[name] = value;
  }
  return values;
}

std::string key_in(const std::map<std::string, std::string>& values, const char* name,
                   const fs::path& file) {
  const auto found = values.find(name);
  if (found == values.end() || !is_key(found->second)) {
    throw InputError(file.string() + " has no " + name +
                     " key of 40 characters: make a new key with parray keygen");
  }
  return found->second;
}

std::string member_text(const std::string& coordinator, const KeyPair& pair, Role role,
                        const std::string& name) {
  return "# ParRay: key of " + std::string(name_of(role)) + " '" + name +
         "'. Its owner may connect.\ncoordinator " + coordinator + "\npublic " + pair.open +
         "\nsecret " + pair.secret + "\n";
}

fs::path allowed_file(const fs::path& directory) { return directory / "allowed"; }

struct Member {
  Role role;
  std::string name;
  std::string key;
  double share = 1;
};

/// Reads the rest of a line: nothing or a share.
bool read_share(std::istringstream& words, double& share) {
  if (words >> std::ws; words.eof()) return true;
  return words >> share && share >= least_share && share <= largest_share &&
         (words >> std::ws).eof();
}

std::vector<Member> read_members(const fs::path& file) {
  std::vector<Member> members;
  std::istringstream lines(key_text(file));
  refuse_if_others_can_write(file.parent_path());
  refuse_if_others_can_write(file);
  std::size_t number = 0;
  for (std::string line; std::getline(lines, line);) {
    ++number;
    if (line.empty() || line.starts_with("# ")) continue;
    std::istringstream words(line);
    std::string role;
    Member member{};
    words >> role >> member.name >> member.key;
    const auto known = std::ranges::find_if(roles, [&](Role r) { return name_of(r) == role; });
    if (known == roles.end() || !is_name(member.name) || !is_key(member.key) ||
        !read_share(words, member.share)) {
      throw InputError(
          file.string() + ":" + std::to_string(number) +
          ": not a line 'worker|client|admin NAME PUBLIC-KEY [SHARE]' with a SHARE from "
          "0.001 to 1000");
    }
    member.role = *known;
    members.push_back(std::move(member));
  }
  return members;
}

void write_members(const fs::path& file, const std::vector<Member>& members, bool fresh) {
  std::ostringstream text;
  text << "# ParRay: who may connect. worker|client|admin NAME PUBLIC-KEY [SHARE]\n";
  for (const Member& member : members) {
    text << name_of(member.role) << " " << member.name << " " << member.key;
    if (member.share != 1) text << " " << member.share;
    text << "\n";
  }
  write_key_file(file, text.str(), 0644, fresh);
}

Member make_member(const fs::path& directory, const std::string& coordinator, Role role,
                   const std::string& name) {
  const KeyPair pair = make_key_pair();
  write_key_file(directory / (name + ".key"), member_text(coordinator, pair, role, name), 0600,
                 true);
  return {role, name, pair.open, 1};
}

using Tokens = std::vector<std::pair<std::string, std::string>>;

constexpr std::size_t digest_length = 64;

std::string digest_of(const std::string& token) {
  return sha256_hex(std::as_bytes(std::span(token)));
}

/// Returns no tokens if the file is missing. A link that leads nowhere is not missing.
Tokens read_tokens(const fs::path& directory) {
  const fs::path file = directory / "tokens";
  refuse_if_others_can_write(directory);
  refuse_if_others_can_write(file);
  std::error_code ignored;
  if (fs::symlink_status(file, ignored).type() == fs::file_type::not_found) return {};
  const std::optional<std::string> text = read_file(file);
  if (!text) {
    throw InputError(file.string() + " cannot be read: check its owner and its permissions");
  }
  Tokens tokens;
  std::istringstream lines(*text);
  for (std::string line; std::getline(lines, line);) {
    std::istringstream words(line);
    std::string name;
    std::string digest;
    if (words >> name >> digest && digest.size() == digest_length) {
      tokens.emplace_back(name, digest);
    }
  }
  return tokens;
}

void write_tokens(const fs::path& directory, const Tokens& tokens) {
  std::string text = "# ParRay: tokens for HTTP. NAME SHA-256\n";
  for (const auto& [name, digest] : tokens) text += name + " " + digest + "\n";
  write_key_file(directory / "tokens", text, 0644, false);
}

/// Compares all characters, independent of the first difference.
bool equal(const std::string& a, const std::string& b) {
  unsigned differ = a.size() == b.size() ? 0 : 1;
  for (std::size_t i = 0; i < std::min(a.size(), b.size()); ++i) {
    differ |= static_cast<unsigned char>(a[i]) ^ static_cast<unsigned char>(b[i]);
  }
  return differ == 0;
}

std::string random_text() {
  constexpr std::string_view letters =
      "0123456789abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ-_";
  std::random_device device;
  std::string text = "parray_";
  for (int i = 0; i < 43; ++i) text += letters[device() % letters.size()];
  return text;
}

/// Calls `read` if it was last called a second or more ago.
void read_each_second(Time now, Time& look_again_at, const auto& read) {
  if (now < look_again_at) return;
  look_again_at = now + seconds(1);
  try {
    read();
  } catch (const InputError&) {
    // A file is missing or has a wrong line, or others can write it. Its last valid content counts
    // until the file is repaired.
  }
}

}  // namespace

std::string_view name_of(Role role) {
  constexpr std::array<std::string_view, 5> names = {"none", "worker", "client", "admin", "any"};
  return names.at(static_cast<std::size_t>(role));
}

KeyPair make_key_pair() {
  std::array<char, key_length + 1> open_text{};
  std::array<char, key_length + 1> secret_text{};
  if (zmq_curve_keypair(open_text.data(), secret_text.data()) != 0) {
    throw RunError("this ZeroMQ has no CURVE: install a libzmq with libsodium (Debian: libzmq5)");
  }
  return {open_text.data(), secret_text.data()};
}

void make_farm_keys(const fs::path& directory) {
  std::error_code error;
  const bool made = fs::create_directories(directory, error);
  if (error) {
    throw InputError(directory.string() + ": " + error.message() +
                     ": name a directory that parray can create");
  }
  // Independent of the umask.
  constexpr auto of_others = fs::perms::group_write | fs::perms::others_write;
  if (made) fs::permissions(directory, of_others, fs::perm_options::remove, error);
  refuse_if_others_can_write(directory);
  const KeyPair pair = make_key_pair();
  write_key_file(
      directory / "coordinator.key",
      "# ParRay: the coordinator's own key. Anyone who has it can pose as this farm.\npublic " +
          pair.open + "\nsecret " + pair.secret + "\n",
      0600, true);
  write_members(allowed_file(directory),
                {make_member(directory, pair.open, Role::worker, shared_worker_key),
                 make_member(directory, pair.open, Role::admin, "admin")},
                true);
}

void add_member_key(const fs::path& directory, Role role, const std::string& name, double share) {
  if (name == "coordinator") {
    throw InputError("'coordinator' is the coordinator's own key: use another name");
  }
  if (!is_name(name)) {
    throw InputError("'" + name +
                     "' cannot name a key: use 1 to 64 letters, digits, '.', '_' and '-', but no "
                     "'.' first");
  }
  const KeyPair coordinator = read_coordinator_key(directory);
  std::vector<Member> members = read_members(allowed_file(directory));
  if (std::ranges::any_of(members, [&](const Member& m) { return m.name == name; })) {
    throw InputError("a key named '" + name +
                     "' already exists: use another name, or first remove the key with --remove " +
                     name);
  }
  members.push_back(make_member(directory, coordinator.open, role, name));
  members.back().share = share;
  write_members(allowed_file(directory), members, false);
}

void remove_member_key(const fs::path& directory, const std::string& name) {
  std::vector<Member> members = read_members(allowed_file(directory));
  if (std::erase_if(members, [&](const Member& m) { return m.name == name; }) == 0) {
    throw InputError("no key named '" + name + "' is in " + allowed_file(directory).string());
  }
  write_members(allowed_file(directory), members, false);
  std::error_code ignored;  // a copy elsewhere would remain anyway
  fs::remove(directory / (name + ".key"), ignored);
}

void refuse_if_others_can_write(const fs::path& path) {
  struct stat found {};
  struct statvfs mounted {};
  const bool writable = stat(path.c_str(), &found) == 0 && (found.st_mode & 022) != 0;
  if (!writable || (statvfs(path.c_str(), &mounted) == 0 && (mounted.f_flag & ST_RDONLY) != 0)) {
    return;
  }
  throw InputError(path.string() +
                   " says who may connect, and others on this machine can write it: check its "
                   "content, then chmod go-w " +
                   path.string());
}

KeyPair read_coordinator_key(const fs::path& directory) {
  const fs::path file = directory / "coordinator.key";
  const auto values = read_secret_file(file);
  refuse_if_others_can_write(directory);
  return {key_in(values, "public", file), key_in(values, "secret", file)};
}

fs::path member_key_file(const fs::path& path, const std::string& name) {
  std::error_code ignored;
  return fs::is_directory(path, ignored) ? path / (name + ".key") : path;
}

MemberKey read_member_key(const fs::path& path, const std::string& name) {
  const fs::path file = member_key_file(path, name);
  const auto values = read_secret_file(file);
  return {key_in(values, "coordinator", file),
          {key_in(values, "public", file), key_in(values, "secret", file)}};
}

AllowList::AllowList(const fs::path& directory) : file_(allowed_file(directory)) { read(); }

/// Always reads the file and ignores its modification time, because the clocks of file systems are
/// coarse. Throws InputError.
void AllowList::read() {
  std::map<std::string, Sender> members;
  for (const Member& member : read_members(file_)) {
    members[member.key] = {member.role, member.name, member.share};
  }
  members_ = std::move(members);
}

std::optional<Sender> AllowList::find(Time now, const std::string& open_key) {
  read_each_second(now, look_again_at_, [this] { read(); });
  const auto found = members_.find(open_key);
  return found == members_.end() ? std::nullopt : std::optional(found->second);
}

std::optional<Sender> AllowList::find_name(Time now, const std::string& name) {
  read_each_second(now, look_again_at_, [this] { read(); });
  for (const auto& [key, member] : members_) {
    if (member.name == name) return member;
  }
  return std::nullopt;
}

std::string make_token(const fs::path& directory, const std::string& name) {
  AllowList allowed(directory);
  const auto owner = allowed.find_name(Time(0), name);
  if (owner && owner->role == Role::worker) {
    throw InputError("'" + name +
                     "' is the key of a worker: tokens are for clients and administrators");
  }
  if (!owner) {
    throw InputError("'" + name + "' is no client or administrator of this farm: parray keygen " +
                     directory.string() + " --role client --name " + name + " adds a client");
  }
  Tokens tokens = read_tokens(directory);
  std::erase_if(tokens, [&](const auto& entry) { return entry.first == name; });
  std::string token = random_text();
  tokens.emplace_back(name, digest_of(token));
  write_tokens(directory, tokens);
  return token;
}

void remove_token(const fs::path& directory, const std::string& name) {
  Tokens tokens = read_tokens(directory);
  if (std::erase_if(tokens, [&](const auto& entry) { return entry.first == name; }) > 0) {
    write_tokens(directory, tokens);
  }
}

void check_key_lists(const fs::path& directory) { const TokenList readable(directory); }

TokenList::TokenList(const fs::path& directory)
    : directory_(directory), allowed_(directory), tokens_(read_tokens(directory)) {}

std::optional<Sender> TokenList::find(Time now, const std::string& token) {
  read_each_second(now, look_again_at_, [this] { tokens_ = read_tokens(directory_); });
  const std::string digest = digest_of(token);
  std::string name;
  for (const auto& [owner, known] : tokens_) {
    if (equal(known, digest)) name = owner;
  }
  return name.empty() ? std::nullopt : allowed_.find_name(now, name);
}

}  // namespace parray::proto
