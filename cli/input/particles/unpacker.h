#pragma once

#include <cstddef>
#include <string>

#include "common/rooms.h"

/// Unpacks data from front to back. zlib unpacks gzip and checks its checksum, which libarchive 3.6
/// ignores. libarchive unpacks all other compressed data. It is in a module (unpack_archive.cpp)
/// that ParRay loads for the first such file, because loading its dozen libraries would delay all
/// commands.
namespace parray::input {

class Unpacker {
 public:
  Unpacker& operator=(Unpacker&&) = delete;
  virtual ~Unpacker() = default;

  /// Fills `to` with the next `bytes` bytes, fewer only at the end of the data. Returns their
  /// number. Returns -1 if the data are damaged or incomplete; problem() tells why.
  virtual std::ptrdiff_t read(char* to, std::size_t bytes) = 0;
  /// Returns why read() failed, for messages.
  [[nodiscard]] virtual std::string problem() const = 0;
};

/// The only function that the module exports. Returns an Unpacker of an open file, from the front
/// of the file. The caller deletes it. The descriptor stays open and must outlive the Unpacker.
using UnpackerEntry = Unpacker* (*)(int file);
inline constexpr const char* unpacker_entry = "parray_unpack";

}  // namespace parray::input
