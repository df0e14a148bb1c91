#pragma once

#include <cstddef>
#include <memory>
#include <span>
#include <string>
#include <string_view>

#include "common/rooms.h"

struct evp_md_ctx_st;  // of OpenSSL

namespace parray::base {

/// Computes the SHA-256 of bytes that arrive in parts. Throws std::runtime_error if OpenSSL fails.
class Sha256 {
 public:
  Sha256();

  void add(std::span<const std::byte> bytes);
  /// Returns the hash as 64 lower-case hexadecimal digits. No other call may follow.
  std::string hex();

 private:
  struct Free {
    void operator()(evp_md_ctx_st* context) const noexcept;
  };
  std::unique_ptr<evp_md_ctx_st, Free> context_;
};

/// Returns the SHA-256 of `bytes` as 64 lower-case hexadecimal digits.
std::string sha256_hex(std::span<const std::byte> bytes);

/// Returns whether `text` has the form of a SHA-256: 64 lower-case hexadecimal digits.
bool is_sha256_hex(std::string_view text);

}  // namespace parray::base
