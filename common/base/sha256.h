#pragma once

#include <cstddef>
#include <memory>
#include <span>
#include <string>

#include "common/rooms.h"

namespace parray::base {

/// SHA-256 of bytes that come in parts.
class Sha256 {
 public:
  Sha256();
  ~Sha256();
  Sha256(const Sha256&) = delete;
  Sha256& operator=(const Sha256&) = delete;

  void add(std::span<const std::byte> bytes);
  /// 64 lower-case hexadecimal digits; nothing can be added any more.
  std::string hex();

 private:
  struct State;
  std::unique_ptr<State> state_;
};

/// Of `bytes`.
std::string sha256_hex(std::span<const std::byte> bytes);

}  // namespace parray::base
