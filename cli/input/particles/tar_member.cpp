#include "cli/input/particles/tar_member.h"

#include <algorithm>
#include <array>
#include <numeric>
#include <optional>
#include <utility>
#include <vector>

#include "common/base/text.h"
#include "common/scene/limits.h"

namespace parray::input {
namespace {

enum class TarPart : std::uint8_t { file, attributes, end, unknown };

struct TarHeader {
  TarPart part = TarPart::unknown;
  std::uint64_t bytes = 0;  // of the part's data, without padding
};

using TarBlock = std::array<char, tar_block_bytes>;

constexpr std::size_t sum_at = 148;
constexpr std::size_t sum_bytes = 8;

/// Returns an octal number, which blanks or NUL characters end. Returns nothing for other texts.
std::optional<std::uint64_t> octal_in(const TarBlock& block, std::size_t at, std::size_t bytes) {
  const std::string_view field(block.data() + at, bytes);
  const std::string_view text = field.substr(0, field.find('\0'));
  return parsed<std::uint64_t>(trimmed(text), 8);
}

/// Returns the sum of a header's bytes, where the field of the sum itself counts as blanks.
std::uint64_t checksum_of(TarBlock block) {
  std::fill_n(block.begin() + sum_at, sum_bytes, ' ');
  return std::accumulate(
      block.begin(), block.end(), std::uint64_t{0},
      [](std::uint64_t sum, char c) { return sum + static_cast<unsigned char>(c); });
}

/// Returns what a part contains by its type: files have data, and a pax header, a long name of GNU
/// or a folder belongs to files. Links and sparse files are unknown.
TarPart part_of(char type) {
  if (type == '0' || type == '\0' || type == '7') return TarPart::file;
  constexpr std::string_view attributes = "xgLK5";
  return attributes.find(type) < attributes.size() ? TarPart::attributes : TarPart::unknown;
}

/// Reads the next header. Damaged headers are of an unknown part.
TarHeader next_header(Unpacker& archive) {
  TarBlock block{};
  const std::ptrdiff_t got = archive.read(block.data(), block.size());
  if (got == 0) return {TarPart::end, 0};
  if (got != std::ssize(block)) return {};
  if (std::ranges::count(block, '\0') == got) return {TarPart::end, 0};
  constexpr std::size_t size_at = 124;
  constexpr std::size_t type_at = 156;
  const auto bytes = octal_in(block, size_at, 12);
  const bool good = bytes && *bytes <= limits::max_scene_file_bytes &&
                    octal_in(block, sum_at, sum_bytes) == checksum_of(block);
  return good ? TarHeader{part_of(block[type_at]), *bytes} : TarHeader{};
}

/// Returns the number of bytes that data take in an archive.
std::uint64_t whole_blocks(std::uint64_t bytes) {
  return (bytes + tar_block_bytes - 1) / tar_block_bytes * tar_block_bytes;
}

/// Reads and forgets bytes. Returns false if there are fewer.
bool pass_over(std::uint64_t bytes, Unpacker& archive) {
  std::vector<char> part(std::min<std::uint64_t>(bytes, std::uint64_t{1} << 17));
  while (bytes > 0) {
    const std::uint64_t next = std::min<std::uint64_t>(bytes, part.size());
    if (archive.read(part.data(), next) != static_cast<std::ptrdiff_t>(next)) return false;
    bytes -= next;
  }
  return true;
}

class TarMember : public Unpacker {
 public:
  explicit TarMember(std::unique_ptr<Unpacker> archive) : archive_(std::move(archive)) {
    TarHeader header = next_header(*archive_);
    while (header.part == TarPart::attributes && pass_over(whole_blocks(header.bytes), *archive_)) {
      header = next_header(*archive_);
    }
    cut_ = header.part != TarPart::file;
    left_ = header.bytes;
  }

  std::ptrdiff_t read(char* to, std::size_t bytes) override {
    if (cut_) return -1;
    const std::size_t wanted = std::min<std::uint64_t>(bytes, left_);
    const std::ptrdiff_t got = archive_->read(to, wanted);
    if (got < 0) return got;
    left_ -= static_cast<std::uint64_t>(got);
    cut_ = static_cast<std::size_t>(got) < wanted;
    return cut_ ? -1 : got;
  }

  [[nodiscard]] std::string problem() const override {
    return cut_ ? "the archive ends within the file" : archive_->problem();
  }

 private:
  std::unique_ptr<Unpacker> archive_;
  std::uint64_t left_ = 0;  // bytes of the file that are not read
  bool cut_ = false;        // the archive ends before the file
};

}  // namespace

bool begins_tar(std::string_view start) {
  constexpr std::size_t magic_at = 257;
  return start.size() >= tar_block_bytes && start.substr(magic_at).starts_with("ustar");
}

bool has_one_file(Unpacker& archive) {
  int files = 0;
  std::uint64_t total = 0;
  while (total <= limits::max_scene_file_bytes) {
    const TarHeader header = next_header(archive);
    if (header.part == TarPart::end) return files == 1;
    files += header.part == TarPart::file ? 1 : 0;
    if (header.part == TarPart::unknown || files > 1) return false;
    if (!pass_over(whole_blocks(header.bytes), archive)) return false;
    total += tar_block_bytes + whole_blocks(header.bytes);
  }
  return false;
}

std::unique_ptr<Unpacker> tar_member(std::unique_ptr<Unpacker> archive) {
  return std::make_unique<TarMember>(std::move(archive));
}

}  // namespace parray::input
