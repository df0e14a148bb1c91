#include "cli/input/formats/gsd_file.h"

#include "common/base/printable.h"

namespace parray::input {
namespace {

constexpr std::size_t gsd_header_bytes = 256;
constexpr std::size_t index_entry_bytes = 32;
constexpr std::size_t short_name_bytes = 64;  // length of a name in version 1, and unit of the list
constexpr std::uint64_t largest_file_bytes = std::uint64_t{1} << 62;

/// Sizes of numbers, by GsdType.
constexpr std::array<std::uint64_t, 12> gsd_type_bytes{0, 1, 2, 4, 8, 1, 2, 4, 8, 4, 8, 1};

template <typename T>
T value_at(const char* from) {
  return binary_value<T>(from, std::endian::native != std::endian::little);
}

/// Returns the text up to its first zero byte.
std::string_view up_to_zero(std::string_view text) { return text.substr(0, text.find('\0')); }

}  // namespace

std::uint64_t GsdChunk::number_bytes() const {
  return gsd_type_bytes.at(static_cast<std::size_t>(type));
}

GsdFile::GsdFile(PackedFile& file) : file_(file), place_{file.name()} {
  place_.unit = FilePlace::Unit::byte;
  file_.rewind();
  read_header();
}

void GsdFile::expect(std::uint64_t location, std::uint64_t bytes) const {
  if (location > largest_file_bytes || bytes > largest_file_bytes) {
    fail_damaged("the file states an impossible place or size of data");
  }
  if (size().value_or(UINT64_MAX) >= location + bytes) return;
  place_.fail_incomplete("the file ends within its data");
}

void GsdFile::read_at(std::uint64_t location, char* to, std::size_t bytes) {
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

void GsdFile::read_header() {
  std::array<char, gsd_header_bytes> header{};
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
    fail("the file has version " + std::to_string(major) + "." + std::to_string(version & 0xFFFF) +
         " of GSD: write it with version 1 or 2");
  }
  schema_ = up_to_zero({header.data() + 112, short_name_bytes});
  constexpr std::uint64_t most_entries = largest_file_bytes / index_entry_bytes;
  constexpr std::uint64_t most_names = std::uint64_t{1} << 18;  // 16 MiB
  if (index_entries_ > most_entries || names > most_names) fail_damaged("the header is not valid");
  expect(index_location_, index_entries_ * index_entry_bytes);
  expect(names_location_, names * short_name_bytes);
  read_names(major, names * short_name_bytes);
}

/// Reads the names of the chunks. Version 1 gives each name 64 bytes. Version 2 ends each name with
/// a zero byte.
void GsdFile::read_names(std::uint64_t version, std::uint64_t bytes) {
  constexpr std::size_t most_names = UINT16_MAX;  // entries of the index have 16 bits for a name
  std::string text;
  while (text.size() < bytes) {
    const std::size_t before = text.size();
    text.resize(static_cast<std::size_t>(std::min<std::uint64_t>(bytes, before + block_bytes)));
    read_at(names_location_ + before, text.data() + before, text.size() - before);
  }
  std::string_view rest = text;
  while (!rest.empty() && rest[0] != '\0' && names_.size() < most_names) {
    names_.emplace_back(up_to_zero(version < 2 ? rest.substr(0, short_name_bytes) : rest));
    rest.remove_prefix(
        std::min(rest.size(), version < 2 ? short_name_bytes : names_.back().size() + 1));
  }
}

/// Reads the next block of the index. Returns false at its end.
bool GsdFile::fill_index() {
  const std::uint64_t left = index_entries_ - index_read_;
  const auto count =
      static_cast<std::size_t>(std::min<std::uint64_t>(left, block_bytes / index_entry_bytes));
  block_.resize(count * index_entry_bytes);
  block_next_ = 0;
  if (count == 0) return false;
  read_at(index_location_ + index_read_ * index_entry_bytes, block_.data(), block_.size());
  index_read_ += count;
  return true;
}

GsdChunk GsdFile::chunk_at(const char* entry) const {
  GsdChunk chunk;
  chunk.frame = value_at<std::uint64_t>(entry);
  chunk.rows = value_at<std::uint64_t>(entry + 8);
  chunk.location = value_at<std::uint64_t>(entry + 16);
  chunk.columns = value_at<std::uint32_t>(entry + 24);
  chunk.name = value_at<std::uint16_t>(entry + 28);
  const auto type = static_cast<unsigned char>(entry[30]);
  // A file has at least one chunk per frame, apart from frames that repeat the first one.
  if (type == 0 || type >= gsd_type_bytes.size() || chunk.name >= names_.size() ||
      chunk.frame >= index_entries_ || chunk.frame < last_frame_) {
    fail_damaged("the index has an invalid entry");
  }
  chunk.type = static_cast<GsdType>(type);
  return chunk;
}

std::optional<GsdChunk> GsdFile::next_chunk() {
  if (block_next_ == block_.size() && !fill_index()) return {};
  const char* const entry = block_.data() + block_next_;
  place_.number =
      index_location_ + (index_read_ * index_entry_bytes - (block_.size() - block_next_));
  if (value_at<std::uint64_t>(entry + 16) == 0) return {};
  block_next_ += index_entry_bytes;
  const GsdChunk chunk = chunk_at(entry);
  last_frame_ = chunk.frame;
  return chunk;
}

void GsdFile::check(const GsdChunk& chunk) const {
  if (chunk.rows > limits::max_shapes) {
    fail_damaged("the chunk " + printable(names_[chunk.name]) + " has " +
                 std::to_string(chunk.rows) + " rows");
  }
  expect(chunk.location, chunk.bytes());
}

std::vector<std::string> GsdFile::texts(const GsdChunk& chunk) {
  check(chunk);
  std::vector<std::string> texts;
  if (chunk.number_bytes() != 1 || chunk.columns > max_text_bytes) {
    fail_damaged("the chunk " + printable(names_[chunk.name]) + " does not have texts of at most " +
                 std::to_string(max_text_bytes) + " bytes");
  }
  if (chunk.columns == 0) return texts;
  std::string row(chunk.columns, '\0');
  for (std::uint64_t i = 0; i < chunk.rows; ++i) {
    read_at(chunk.location + i * chunk.columns, row.data(), row.size());
    texts.emplace_back(up_to_zero(row));
  }
  return texts;
}

}  // namespace parray::input
