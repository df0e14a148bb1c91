#include "coordinator/http/frames_zip.h"

#include <unistd.h>
#include <zlib.h>

#include <algorithm>
#include <cerrno>
#include <system_error>

#include "common/base/error.h"

namespace parray::http {
namespace {

constexpr std::uint64_t most_32 = 0xFFFFFFFF;
constexpr std::uint16_t zip_64_version = 45;
constexpr std::uint16_t utf_8_names = 1U << 11U;
constexpr std::uint32_t first_day = (1U << 21U) | (1U << 16U);  // 1980-01-01: equal bits each time

/// Returns the numbers as little-endian bytes: pairs of a value and its number of bytes.
std::string zip_record(std::initializer_list<std::pair<std::uint64_t, unsigned>> fields) {
  std::string bytes;
  for (auto [value, size] : fields) {
    for (; size > 0; --size, value >>= 8U) bytes += static_cast<char>(value & 0xFFU);
  }
  return bytes;
}

std::string read_part(const FileBody& file, std::uint64_t from) {
  constexpr std::uint64_t most = std::uint64_t{1} << 18;
  const std::uint64_t size = file.bytes().size();
  std::string part(std::min(most, size - from), '\0');
  const ssize_t got = pread(file.descriptor(), part.data(), part.size(), static_cast<off_t>(from));
  if (got != static_cast<ssize_t>(part.size())) {
    throw RunError("reading a picture failed: " + std::generic_category().message(errno));
  }
  return part;
}

/// Returns the CRC-32 (ISO 3309) of the file.
std::uint64_t crc_of(const FileBody& file) {
  uLong crc = 0;
  for (std::uint64_t at = 0; at < file.bytes().size();) {
    const std::string part = read_part(file, at);
    crc = crc32(crc, reinterpret_cast<const Bytef*>(part.data()), static_cast<uInt>(part.size()));
    at += part.size();
  }
  return crc;
}

}  // namespace

std::optional<std::string> ZipStream::next() {
  if (ended_) return {};
  std::string piece;
  if (file_ && sent_of_file_ < file_->bytes().size()) {
    piece = read_part(*file_, sent_of_file_);
    sent_of_file_ += piece.size();
  } else if (begun_ < members_.size()) {
    piece = begin_member();
  } else {
    piece = directory();
    ended_ = true;
  }
  sent_ += piece.size();
  return piece;
}

/// Opens the next file. Returns its header, and adds it to the directory.
std::string ZipStream::begin_member() {
  const Member& member = members_.at(begun_++);
  file_.reset();  // so that only one file exists
  file_ = member.open();
  sent_of_file_ = 0;
  const std::uint64_t size = file_->bytes().size();
  if (size >= most_32) throw RunError(member.name + " is larger than 4 GiB");
  const std::uint64_t crc = crc_of(*file_);
  const bool far = sent_ >= most_32;
  const std::string common = zip_record({{zip_64_version, 2},
                                         {utf_8_names, 2},
                                         {0, 2},  // stored
                                         {first_day, 4},
                                         {crc, 4},
                                         {size, 4},
                                         {size, 4},
                                         {member.name.size(), 2}});
  const std::string place = far ? zip_record({{1, 2}, {8, 2}, {sent_, 8}}) : std::string();
  directory_ += zip_record({{0x02014B50, 4}, {zip_64_version, 2}}) + common +
                zip_record({{place.size(), 2},
                            {0, 2},  // comment
                            {0, 2},  // disk
                            {0, 2},
                            {0, 4},  // attributes
                            {far ? most_32 : sent_, 4}}) +
                member.name + place;
  return zip_record({{0x04034B50, 4}}) + common + zip_record({{0, 2}}) + member.name;
}

std::string ZipStream::directory() {
  const std::uint64_t count = members_.size();
  const std::uint64_t size = directory_.size();
  const bool far = sent_ >= most_32;
  std::string end = std::move(directory_);
  if (far) {
    end += zip_record({{0x06064B50, 4},
                       {44, 8},  // bytes that follow
                       {zip_64_version, 2},
                       {zip_64_version, 2},
                       {0, 4},
                       {0, 4},
                       {count, 8},
                       {count, 8},
                       {size, 8},
                       {sent_, 8}});
    end += zip_record({{0x07064B50, 4}, {0, 4}, {sent_ + size, 8}, {1, 4}});
  }
  // A series has at most 10,000 frames, so that their number fits.
  return end + zip_record({{0x06054B50, 4},
                           {0, 2},
                           {0, 2},
                           {count, 2},
                           {count, 2},
                           {size, 4},
                           {far ? most_32 : sent_, 4},
                           {0, 2}});
}

}  // namespace parray::http
