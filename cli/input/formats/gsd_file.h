#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "cli/input/formats/binary_input.h"
#include "cli/input/particles/file_place.h"
#include "cli/input/particles/packed_file.h"
#include "common/base/printable.h"

namespace parray::input {

/// Types of numbers in GSD, by their numbers in the file.
enum class GsdType : std::uint8_t {
  uint8 = 1,
  uint16,
  uint32,
  uint64,
  int8,
  int16,
  int32,
  int64,
  float32,
  float64,
  character
};

/// A matrix of numbers in a GSD file: an entry of the index.
struct GsdChunk {
  std::uint64_t frame = 0;  ///< number of the frame, from 0, below 2^63
  std::uint64_t rows = 0;
  std::uint64_t location = 0;  ///< its first byte in the file; next_chunk() does not check it
  std::uint32_t columns = 0;
  std::uint16_t name = 0;  ///< index of GsdFile::names()
  GsdType type{};

  /// Sizes of numbers, by GsdType.
  static constexpr std::array<std::uint64_t, 12> bytes_of_types{0, 1, 2, 4, 8, 1, 2, 4, 8, 4, 8, 1};

  /// Returns the size of a number.
  [[nodiscard]] std::uint64_t number_bytes() const {
    return bytes_of_types.at(static_cast<std::size_t>(type));
  }
  [[nodiscard]] std::uint64_t count() const { return rows * columns; }
  [[nodiscard]] std::uint64_t bytes() const { return count() * number_bytes(); }
};

/// The file layer of GSD (gsd.readthedocs.io, "File layer"), versions 0.3, 1 and 2: a header, a
/// list of names, an index sorted by frames, and chunks. Reads the index from front to back, and
/// chunks in any order. To go back in a packed file, it unpacks the file again from the beginning.
/// It does so at most 64 times, and then throws InputError. Keeps one block of the index in memory.
/// All members throw InputError for damaged files.
class GsdFile {
 public:
  /// Reads the header and the names. `file` must outlive this object.
  explicit GsdFile(PackedFile& file) : file_(file), place_{file.name()} {
    place_.unit = FilePlace::Unit::byte;
    file_.rewind();
    read_header();
  }

  [[nodiscard]] const std::string& schema() const { return schema_; }
  [[nodiscard]] const std::vector<std::string>& names() const { return names_; }

  /// Returns the next entry of the index; nothing after the last one. The frames never descend.
  std::optional<GsdChunk> next_chunk() {
    if (block_next_ == block_.size() && !fill_index()) return {};
    const char* const entry = block_.data() + block_next_;
    place_.number = index_location_ + (index_read_ * entry_bytes - (block_.size() - block_next_));
    if (value_at<std::uint64_t>(entry + 16) == 0) return {};
    block_next_ += entry_bytes;
    const GsdChunk chunk = chunk_at(entry);
    last_frame_ = chunk.frame;
    return chunk;
  }

  /// Throws InputError for more than limits::max_shapes rows, and if the file is known to end
  /// before the end of the chunk. Only reading finds the end of a packed file. numbers() and
  /// texts() call check().
  void check(const GsdChunk& chunk) const {
    if (chunk.rows > limits::max_shapes) {
      fail_damaged("the chunk " + printable(names_[chunk.name]) + " has " +
                   std::to_string(chunk.rows) + " rows");
    }
    expect(chunk.location, chunk.bytes());
  }

  /// Calls `put(value)` with each number of the chunk as a double, row by row.
  void numbers(const GsdChunk& chunk, const auto& put) {
    check(chunk);
    switch (chunk.type) {
      case GsdType::uint8: return numbers_of<std::uint8_t>(chunk, put);
      case GsdType::uint16: return numbers_of<std::uint16_t>(chunk, put);
      case GsdType::uint32: return numbers_of<std::uint32_t>(chunk, put);
      case GsdType::uint64: return numbers_of<std::uint64_t>(chunk, put);
      case GsdType::int8: return numbers_of<std::int8_t>(chunk, put);
      case GsdType::int16: return numbers_of<std::int16_t>(chunk, put);
      case GsdType::int32: return numbers_of<std::int32_t>(chunk, put);
      case GsdType::int64: return numbers_of<std::int64_t>(chunk, put);
      case GsdType::float32: return numbers_of<float>(chunk, put);
      case GsdType::float64: return numbers_of<double>(chunk, put);
      case GsdType::character: break;
    }
    fail_damaged("a chunk has texts instead of numbers");
  }

  static constexpr std::uint32_t max_text_bytes = 1U << 16;
  /// Returns the rows of a chunk of bytes as texts, each up to its first zero byte. Throws
  /// InputError for numbers of more than one byte and for rows of more than max_text_bytes.
  std::vector<std::string> texts(const GsdChunk& chunk) {
    check(chunk);
    std::vector<std::string> texts;
    if (chunk.number_bytes() != 1 || chunk.columns > max_text_bytes) {
      fail_damaged("the chunk " + printable(names_[chunk.name]) +
                   " does not have texts of at most " + std::to_string(max_text_bytes) + " bytes");
    }
    if (chunk.columns == 0) return texts;
    std::string row(chunk.columns, '\0');
    for (std::uint64_t i = 0; i < chunk.rows; ++i) {
      read_at(chunk.location + i * chunk.columns, row.data(), row.size());
      texts.emplace_back(up_to_zero(row));
    }
    return texts;
  }

  /// Returns the number of bytes of the file; nothing for packed files.
  [[nodiscard]] std::optional<std::uint64_t> size() const { return file_.size(); }
  [[nodiscard]] const FilePlace& place() const { return place_; }
  /// Throws InputError with the file, the place and `problem`.
  [[noreturn]] void fail(std::string_view problem) const { place_.fail(problem); }
  /// Does the same and adds that the file is probably damaged.
  [[noreturn]] void fail_damaged(std::string_view problem) const { place_.fail_damaged(problem); }

 private:
  static constexpr std::size_t block_bytes = std::size_t{1} << 16;
  static constexpr std::size_t header_bytes = 256;
  static constexpr std::size_t entry_bytes = 32;  // of the index
  static constexpr std::size_t name_bytes = 64;   // of a name in version 1; unit of the list
  static constexpr std::uint64_t largest_file_bytes = std::uint64_t{1} << 62;

  template <typename T>
  static T value_at(const char* from) {
    return binary_value<T>(from, std::endian::native != std::endian::little);
  }

  /// Returns the text up to its first zero byte.
  static std::string_view up_to_zero(std::string_view text) {
    return text.substr(0, text.find('\0'));
  }

  void expect(std::uint64_t location, std::uint64_t bytes) const {
    if (location > largest_file_bytes || bytes > largest_file_bytes) {
      fail_damaged("the file states an impossible place or size of data");
    }
    if (size().value_or(UINT64_MAX) >= location + bytes) return;
    place_.fail_incomplete("the file ends within its data");
  }

  void read_at(std::uint64_t location, char* to, std::size_t bytes) {
    constexpr int most_rewinds = 64;
    place_.number = location;
    expect(location, bytes);
    if (location < position_) {
      if (!size() && ++rewinds_ > most_rewinds) {
        fail("the packed file would have to be unpacked many times: unpack it first");
      }
      file_.rewind();
      position_ = 0;
    }
    const bool there = file_.skip(location - position_);
    position_ = location;
    const std::size_t got = there ? file_.read(to, bytes) : 0;
    position_ += got;
    if (got < bytes) place_.fail_incomplete("the file ends within its data");
  }

  void read_header() {
    std::array<char, header_bytes> header{};
    read_at(0, header.data(), header.size());
    constexpr std::uint64_t magic = 0x65DF65DF65DF65DF;
    const auto number = [&](std::size_t at) { return value_at<std::uint64_t>(header.data() + at); };
    if (number(0) != magic) fail("this is not a GSD file: it does not begin with the bytes of GSD");
    index_location_ = number(8);
    index_entries_ = number(16);
    names_location_ = number(24);
    const std::uint64_t names = number(32);
    const auto version = value_at<std::uint32_t>(header.data() + 44);
    const std::uint32_t major = version >> 16;
    constexpr std::uint32_t version_0_3 = 3;
    if (version != version_0_3 && major != 1 && major != 2) {
      fail("the file has version " + std::to_string(major) + "." +
           std::to_string(version & 0xFFFF) + " of GSD: write it with version 1 or 2");
    }
    schema_ = up_to_zero({header.data() + 112, name_bytes});
    constexpr std::uint64_t most_entries = largest_file_bytes / entry_bytes;
    constexpr std::uint64_t most_names = std::uint64_t{1} << 18;  // 16 MiB
    if (index_entries_ > most_entries || names > most_names) {
      fail_damaged("the header is not valid");
    }
    expect(index_location_, index_entries_ * entry_bytes);
    expect(names_location_, names * name_bytes);
    read_names(major, names * name_bytes);
  }

  /// Reads the names of the chunks. Version 1 gives each name 64 bytes. Version 2 ends each name
  /// with a zero byte.
  void read_names(std::uint64_t version, std::uint64_t bytes) {
    constexpr std::size_t most_names = UINT16_MAX;  // entries of the index have 16 bits for a name
    std::string text;
    while (text.size() < bytes) {
      const std::size_t before = text.size();
      text.resize(static_cast<std::size_t>(std::min<std::uint64_t>(bytes, before + block_bytes)));
      read_at(names_location_ + before, text.data() + before, text.size() - before);
    }
    std::string_view rest = text;
    while (!rest.empty() && rest[0] != '\0' && names_.size() < most_names) {
      names_.emplace_back(up_to_zero(version < 2 ? rest.substr(0, name_bytes) : rest));
      rest.remove_prefix(
          std::min(rest.size(), version < 2 ? name_bytes : names_.back().size() + 1));
    }
  }

  /// Reads the next block of the index. Returns false at its end.
  bool fill_index() {
    const std::uint64_t left = index_entries_ - index_read_;
    const auto count =
        static_cast<std::size_t>(std::min<std::uint64_t>(left, block_bytes / entry_bytes));
    block_.resize(count * entry_bytes);
    block_next_ = 0;
    if (count == 0) return false;
    read_at(index_location_ + index_read_ * entry_bytes, block_.data(), block_.size());
    index_read_ += count;
    return true;
  }

  GsdChunk chunk_at(const char* entry) const {
    GsdChunk chunk;
    chunk.frame = value_at<std::uint64_t>(entry);
    chunk.rows = value_at<std::uint64_t>(entry + 8);
    chunk.location = value_at<std::uint64_t>(entry + 16);
    chunk.columns = value_at<std::uint32_t>(entry + 24);
    chunk.name = value_at<std::uint16_t>(entry + 28);
    const auto type = static_cast<unsigned char>(entry[30]);
    // A file has at least one chunk per frame, apart from frames that repeat the first one.
    if (type == 0 || type >= GsdChunk::bytes_of_types.size() || chunk.name >= names_.size() ||
        chunk.frame >= index_entries_ || chunk.frame < last_frame_) {
      fail_damaged("the index has an invalid entry");
    }
    chunk.type = static_cast<GsdType>(type);
    return chunk;
  }

  template <typename T, typename Put>
  void numbers_of(const GsdChunk& chunk, const Put& put) {
    std::array<char, block_bytes> block{};
    for (std::uint64_t done = 0; done < chunk.bytes();) {
      const auto part =
          static_cast<std::size_t>(std::min<std::uint64_t>(block.size(), chunk.bytes() - done));
      read_at(chunk.location + done, block.data(), part);
      for (std::size_t at = 0; at < part; at += sizeof(T)) {
        put(static_cast<double>(value_at<T>(block.data() + at)));
      }
      done += part;
    }
  }

  PackedFile& file_;
  FilePlace place_;
  std::uint64_t position_ = 0;  // of the file
  int rewinds_ = 0;             // of a packed file
  std::string schema_;
  std::vector<std::string> names_;
  std::uint64_t names_location_ = 0;
  std::uint64_t index_location_ = 0;
  std::uint64_t index_entries_ = 0;  // allocated; the first one without a location ends the index
  std::uint64_t index_read_ = 0;     // entries that have been read into the block
  std::string block_;                // of the index
  std::size_t block_next_ = 0;
  std::uint64_t last_frame_ = 0;
};

}  // namespace parray::input
