#include "cli/output/preview.h"

#include <algorithm>
#include <utility>

#include "common/image/image_file.h"

namespace parray {

Preview::Preview(std::filesystem::path file, std::function<void()> while_writing)
    : file_(std::move(file)), while_writing_(std::move(while_writing)) {
  if (wanted()) check_image_path(file_);
}

void Preview::follow(Time now, const JobStatus& status, const std::function<Image()>& partial) {
  if (!wanted() || status.ended() || now < next_) return;
  began_ = began_.value_or(now);
  if (!status.whole && (status.progress == 0 || now - *began_ < seconds(1))) return;
  const SteadyClock clock;
  const Time begin = clock.now();
  write_image(file_, partial(), {{"parray:partial", "true"}}, {}, while_writing_);
  const Time took = clock.now() - begin;
  next_ = now + std::max(10 * took, Time(milliseconds(500)));
}

}  // namespace parray
