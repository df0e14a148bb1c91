#pragma once

#include <cstddef>
#include <memory>
#include <string>
#include <string_view>

#include "common/rooms.h"

/// Packed data, expanded from front to back. Of gzip by zlib, which compares the data's checksum
/// (libarchive 3.6 passes it over); of all others by libarchive, in a module that is loaded for the
/// first such file: it brings a dozen libraries, and no command is to wait for them that needs
/// none. The seam between packed_file.cpp and unpack_archive.cpp, which is the module.
namespace parray::input {

class Unpacker {
 public:
  Unpacker() = default;
  Unpacker(const Unpacker&) = delete;
  Unpacker& operator=(const Unpacker&) = delete;
  virtual ~Unpacker() = default;

  /// Fills `to` with the next `bytes` bytes, fewer only at the end of the data; returns how many,
  /// or -1 when they are damaged or cut: see problem().
  virtual std::ptrdiff_t read(char* to, std::size_t bytes) = 0;
  [[nodiscard]] virtual std::string problem() const = 0;
};

/// Of an open file, from its front; its descriptor stays open and outlives this.
std::unique_ptr<Unpacker> unpack_gzip(int file);

/// The same of every other packing, by the one name that the module exports.
using UnpackerEntry = Unpacker* (*)(int file);
inline constexpr const char* unpacker_entry = "parray_unpack";

}  // namespace parray::input
