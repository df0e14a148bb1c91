#include "cli/plan/overheads.h"

#include <malloc.h>
#include <unistd.h>

#include <algorithm>
#include <string>
#include <system_error>

#include "common/image/error_estimate.h"
#include "common/image/image.h"
#include "common/image/image_file.h"
#include "common/image/picture_bytes.h"
#include "proto/messages.h"

namespace parray {
namespace {

namespace fs = std::filesystem;

/// A file that is gone when this is.
class ScratchFile {
 public:
  explicit ScratchFile(const fs::path& extension)
      : path_(fs::temp_directory_path() /
              ("parray-plan-" + std::to_string(getpid()) + extension.string())) {}
  ~ScratchFile() {
    std::error_code ignored;
    fs::remove(path_, ignored);
  }
  ScratchFile(const ScratchFile&) = delete;
  ScratchFile& operator=(const ScratchFile&) = delete;
  [[nodiscard]] const fs::path& path() const { return path_; }

 private:
  fs::path path_;
};

double mean_of(const Image& image) {
  double sum = 0;
  for (const float value : image.rgb) {
    sum += static_cast<double>(value);
  }
  return image.rgb.empty() ? 0 : sum / static_cast<double>(image.rgb.size());
}

}  // namespace

void forget_memory() {
  constexpr int large = 128 * 1024;  // glibc's own bound, which it would raise with use
  mallopt(M_MMAP_THRESHOLD, large);  // NOLINT(concurrency-mt-unsafe): before other threads allocate
}

Effort effort_of_collecting(const Framebuffer& traced) {
  const Effort began = effort_now();
  const std::uint32_t most = *std::max_element(traced.samples().begin(), traced.samples().end());
  const WorkRect rect{0, traced.height(), 0, most};
  const std::string sent =
      row_block_to_bytes({rect, traced.width(), traced.counts(), traced.pixels()});
  const RowBlock received = row_block_from_bytes(std::string(sent));
  const std::string kept = row_block_to_bytes(received);
  return effort_now() - began;
}

Finished finish(const DirectRender& picture, const fs::path& extension) {
  const Effort began = effort_now();
  const Image image = resolve_image(picture.framebuffer, picture.largest_radiance);
  const ErrorEstimate error = estimate_error(picture.state());
  for (int side = 0; side < 2; ++side) {  // who made it, and who fetches it
    image_sha256(image);
  }
  const std::string bytes =
      picture_to_bytes(image, {picture.framebuffer.samples(), error.half_width});
  picture_from_bytes(image.width, image.height, bytes);
  const ScratchFile file(extension);
  write_image(file.path(), image, {});
  return {effort_now() - began, mean_of(image)};
}

}  // namespace parray
