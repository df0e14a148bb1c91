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

  [[nodiscard]] std::uint64_t number_bytes() const;
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
  explicit GsdFile(PackedFile& file);

  [[nodiscard]] const std::string& schema() const { return schema_; }
  [[nodiscard]] const std::vector<std::string>& names() const { return names_; }

  /// Returns the next entry of the index; nothing after the last one. The frames never descend.
  std::optional<GsdChunk> next_chunk();
  /// Throws InputError for more than limits::max_shapes rows, and if the file is known to end
  /// before the end of the chunk. Only reading finds the end of a packed file. numbers() and
  /// texts() call check().
  void check(const GsdChunk& chunk) const;
  /// Calls `put(value)` with each number of the chunk as a double, row by row.
  void numbers(const GsdChunk& chunk, const auto& put);
  static constexpr std::uint32_t max_text_bytes = 1U << 16;
  /// Returns the rows of a chunk of bytes as texts, each up to its first zero byte. Throws
  /// InputError for numbers of more than one byte and for rows of more than max_text_bytes.
  std::vector<std::string> texts(const GsdChunk& chunk);

  /// Returns the number of bytes of the file; nothing for packed files.
  [[nodiscard]] std::optional<std::uint64_t> size() const { return file_.size(); }
  [[nodiscard]] const FilePlace& place() const { return place_; }
  /// Throws InputError with the file, the place and `problem`.
  [[noreturn]] void fail(std::string_view problem) const { place_.fail(problem); }
  /// Does the same and adds that the file is probably damaged.
  [[noreturn]] void fail_damaged(std::string_view problem) const { place_.fail_damaged(problem); }

 private:
  static constexpr std::size_t block_bytes = std::size_t{1} << 16;

  void read_header();
  void read_names(std::uint64_t version, std::uint64_t bytes);
  bool fill_index();
  GsdChunk chunk_at(const char* entry) const;
  void expect(std::uint64_t location, std::uint64_t bytes) const;
  void read_at(std::uint64_t location, char* to, std::size_t bytes);
  template <typename T, typename Put>
  void numbers_of(const GsdChunk& chunk, const Put& put);

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

template <typename T, typename Put>
void GsdFile::numbers_of(const GsdChunk& chunk, const Put& put) {
  std::array<char, block_bytes> block{};
  for (std::uint64_t done = 0; done < chunk.bytes();) {
    const auto part =
        static_cast<std::size_t>(std::min<std::uint64_t>(block.size(), chunk.bytes() - done));
    read_at(chunk.location + done, block.data(), part);
    for (std::size_t at = 0; at < part; at += sizeof(T)) {
      put(static_cast<double>(
          binary_value<T>(block.data() + at, std::endian::native != std::endian::little)));
    }
    done += part;
  }
}

void GsdFile::numbers(const GsdChunk& chunk, const auto& put) {
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

}  // namespace parray::input
