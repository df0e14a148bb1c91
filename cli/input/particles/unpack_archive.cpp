#include <archive.h>
#include <archive_entry.h>
#include <unistd.h>

#include <memory>

#include "cli/input/particles/unpacker.h"

namespace parray::input {
namespace {

/// Unpacks data of bzip2, xz or zstd, also several concatenated streams. libarchive limits the
/// memory of a stream: 1 GiB for xz, a window of 128 MiB for zstd.
class Archive : public Unpacker {
 public:
  explicit Archive(int file) : archive_(archive_read_new()) {
    constexpr std::size_t buffer_bytes = std::size_t{1} << 17;
    if (archive_ == nullptr) return;
    archive_read_support_filter_bzip2(archive_.get());
    archive_read_support_filter_xz(archive_.get());
    archive_read_support_filter_zstd(archive_.get());
    archive_read_support_format_raw(archive_.get());
    archive_read_support_format_empty(archive_.get());
    lseek(file, 0, SEEK_SET);
    if (archive_read_open_fd(archive_.get(), file, buffer_bytes) != ARCHIVE_OK) return;
    archive_entry* entry = nullptr;
    const int status = archive_read_next_header(archive_.get(), &entry);
    const bool unpacks = archive_filter_code(archive_.get(), 0) != ARCHIVE_FILTER_NONE;
    open_ = status == ARCHIVE_OK &&
            unpacks;  // libarchive accepts data that are cut after a few bytes as not packed
    empty_ = status == ARCHIVE_EOF;
  }

  std::ptrdiff_t read(char* to, std::size_t bytes) override {
    if (empty_) return 0;
    if (!open_) return -1;
    const la_ssize_t got = archive_read_data(archive_.get(), to, bytes);
    return got < 0 ? -1 : got;
  }

  [[nodiscard]] std::string problem() const override {
    const char* const text = archive_ == nullptr ? nullptr : archive_error_string(archive_.get());
    return text == nullptr ? "the data end too early" : text;
  }

 private:
  struct Free {
    void operator()(archive* opened) const { archive_read_free(opened); }
  };
  std::unique_ptr<archive, Free> archive_;
  bool open_ = false;
  bool empty_ = false;
};

}  // namespace
}  // namespace parray::input

extern "C" [[gnu::visibility("default")]] parray::input::Unpacker* parray_unpack(int file) {
  return new parray::input::Archive(file);
}
