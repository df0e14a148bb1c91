#include <unistd.h>
#include <zlib.h>

#include <algorithm>
#include <cerrno>
#include <system_error>

#include "cli/input/particles/unpacker.h"

namespace parray::input {
namespace {

class Gzip : public Unpacker {
 public:
  explicit Gzip(int file) {
    constexpr unsigned buffer_bytes = 1U << 17;
    lseek(file, 0, SEEK_SET);
    const int copy = dup(file);  // gzclose() closes what it was given
    file_.reset(gzdopen(copy, "rb"));
    if (file_ == nullptr) {
      close(copy);
    } else {
      gzbuffer(file_.get(), buffer_bytes);
    }
  }

  std::ptrdiff_t read(char* to, std::size_t bytes) override {
    if (file_ == nullptr) return -1;
    constexpr std::size_t most_at_once = std::size_t{1} << 30;  // gzread counts in int
    std::size_t done = 0;
    while (done < bytes) {
      const auto part = static_cast<unsigned>(std::min(bytes - done, most_at_once));
      const int got = gzread(file_.get(), to + done, part);
      if (got <= 0) {
        int code = Z_OK;
        gzerror(file_.get(), &code);
        if (code != Z_OK && code != Z_STREAM_END) return -1;
        break;
      }
      done += static_cast<std::size_t>(got);
    }
    return static_cast<std::ptrdiff_t>(done);
  }

  [[nodiscard]] std::string problem() const override {
    int code = Z_ERRNO;
    std::string_view text = file_ == nullptr ? "" : gzerror(file_.get(), &code);
    if (code == Z_ERRNO) return std::generic_category().message(errno);
    const std::size_t name_end = text.find(": ");  // "<fd:3>: reason"
    if (name_end != std::string_view::npos) text.remove_prefix(name_end + 2);
    return std::string(text);
  }

 private:
  struct Close {
    void operator()(gzFile file) const { gzclose_r(file); }
  };
  std::unique_ptr<gzFile_s, Close> file_;
};

}  // namespace

std::unique_ptr<Unpacker> unpack_gzip(int file) { return std::make_unique<Gzip>(file); }

}  // namespace parray::input
