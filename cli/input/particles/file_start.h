#pragma once

#include <cstddef>
#include <cstdint>
#include <string_view>
#include <vector>

#include "common/rooms.h"

namespace parray::input {

/// The first bytes of a file, unpacked: what tells its format.
class FileStart {
 public:
  static constexpr std::size_t max_bytes = std::size_t{1} << 16;

  /// `whole`: the file has no more. `bytes` must outlive this.
  FileStart(std::string_view bytes, bool whole);

  [[nodiscard]] std::string_view bytes() const { return bytes_; }
  [[nodiscard]] bool whole() const { return whole_; }
  /// Whether `signature` stands there, `at` bytes from the front.
  [[nodiscard]] bool has(std::string_view signature, std::size_t at = 0) const {
    return at <= bytes_.size() && bytes_.substr(at).starts_with(signature);
  }
  /// Four bytes as a whole number, least significant first; 0 beyond the end.
  [[nodiscard]] std::uint32_t little_endian(std::size_t at) const;
  /// The same, most significant first.
  [[nodiscard]] std::uint32_t big_endian(std::size_t at) const;

  /// Whether it has no control characters but blanks and the ends of lines and pages.
  [[nodiscard]] bool is_text() const { return is_text_; }
  /// Of text: the lines that are there from end to end, at most max_lines, without their ends, be
  /// they "\n", "\r\n" or "\r", and without a byte order mark. Of anything else: none.
  [[nodiscard]] const std::vector<std::string_view>& lines() const { return lines_; }
  /// Line i, from 0; empty where there is none.
  [[nodiscard]] std::string_view line(std::size_t i) const {
    return i < lines_.size() ? lines_[i] : std::string_view();
  }
  static constexpr std::size_t max_lines = 200;

 private:
  void split_lines(std::string_view text);

  std::string_view bytes_;
  bool whole_;
  bool is_text_;
  std::vector<std::string_view> lines_;
};

/// How sure a recogniser is that a file is of its format.
enum class Likeness : std::uint8_t {
  none,      ///< it is not, or nothing says so
  possible,  ///< nothing says that it is not: only a name, or the lack of any better, decides for
             ///< it
  likely,    ///< the first lines have the format's shape
  certain    ///< a signature that no other format has
};

inline Likeness certain_if(bool condition) {
  return condition ? Likeness::certain : Likeness::none;
}

using Recogniser = Likeness (*)(const FileStart& start);

}  // namespace parray::input
