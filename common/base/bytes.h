#pragma once

#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <span>
#include <stdexcept>
#include <string>
#include <string_view>
#include <type_traits>

#include "common/rooms.h"

namespace parray::base {

static_assert(std::endian::native == std::endian::little,
              "encodings are little-endian; a big-endian machine needs byte swaps here");

template <typename T>
concept PlainNumber = std::is_arithmetic_v<T> || std::is_enum_v<T>;

/// Appends numbers to a byte string, little-endian, without padding.
class ByteWriter {
 public:
  template <PlainNumber T>
  void put(T value) {
    const auto raw = std::bit_cast<std::array<char, sizeof(T)>>(value);
    bytes_.append(raw.data(), raw.size());
  }
  void numbers(const auto&... values) { (put(values), ...); }
  void put_bytes(std::string_view bytes) { bytes_.append(bytes); }
  void reserve(std::size_t size) { bytes_.reserve(size); }
  /// Returns everything written. Must be the last call.
  std::string take() { return std::move(bytes_); }

 private:
  std::string bytes_;
};

/// Thrown if a byte string ends early, continues after its end, or contains an invalid value.
class DecodeError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// Thrown if bytes do not have the checksum that came with them.
class ChecksumError : public DecodeError {
 public:
  using DecodeError::DecodeError;
};

/// Reads the output of ByteWriter. Checks every read and throws DecodeError past the end. Keeps no
/// copy: `bytes` must outlive the reader and the views that get_bytes() returns.
class ByteReader {
 public:
  explicit ByteReader(std::string_view bytes) : bytes_(bytes) {}

  template <PlainNumber T>
  T get() {
    if constexpr (std::is_same_v<T, bool>) return get<std::uint8_t>() != 0;
    std::array<char, sizeof(T)> raw{};
    std::memcpy(raw.data(), get_bytes(sizeof(T)).data(), sizeof(T));
    return std::bit_cast<T>(raw);
  }
  /// Reads what ByteWriter::numbers() wrote. Does not check that the number of an enum is known.
  void numbers(auto&... values) {
    ((values = get<std::remove_reference_t<decltype(values)>>()), ...);
  }

  std::string_view get_bytes(std::size_t size) {
    if (size > bytes_.size()) throw DecodeError("data ends early");
    const std::string_view result = bytes_.substr(0, size);
    bytes_.remove_prefix(size);
    return result;
  }

  /// Returns the number of unread bytes.
  [[nodiscard]] std::size_t left() const { return bytes_.size(); }

  /// Throws DecodeError unless everything has been read.
  void expect_end() const {
    if (!bytes_.empty()) throw DecodeError("data continues after its end");
  }

 private:
  std::string_view bytes_;
};

inline std::span<const std::byte> as_byte_span(std::string_view bytes) {
  return std::as_bytes(std::span(bytes.data(), bytes.size()));
}

}  // namespace parray::base
