#include "proto/tokens.h"

#include <algorithm>
#include <fstream>
#include <random>
#include <span>
#include <sstream>

#include "common/base/error.h"
#include "common/base/files.h"
#include "common/base/sha256.h"

namespace parray::proto {
namespace {

namespace fs = std::filesystem;

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
  const fs::path file = directory / "tokens";
  const fs::path fresh = file.string() + ".new";
  std::ofstream out(fresh);
  out << "# ParRay: tokens for HTTP. NAME SHA-256\n";
  for (const auto& [name, digest] : tokens) out << name << " " << digest << "\n";
  out.close();
  std::error_code error;
  // Independent of the umask.
  constexpr auto of_others = fs::perms::group_write | fs::perms::others_write;
  if (out) fs::permissions(fresh, of_others, fs::perm_options::remove, error);
  if (out && !error) fs::rename(fresh, file, error);
  if (!out || error) throw RunError("writing " + file.string() + " failed");
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

}  // namespace

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
  if (now >= look_again_at_) {
    look_again_at_ = now + seconds(1);
    try {
      tokens_ = read_tokens(directory_);
    } catch (const InputError&) {
      // The file cannot be read, or others can write it. Its last valid content counts until the
      // file is repaired.
    }
  }
  const std::string digest = digest_of(token);
  std::string name;
  for (const auto& [owner, known] : tokens_) {
    if (equal(known, digest)) name = owner;
  }
  return name.empty() ? std::nullopt : allowed_.find_name(now, name);
}

}  // namespace parray::proto
