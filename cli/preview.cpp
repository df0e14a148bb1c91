#include "cli/preview.h"

#include <algorithm>
#include <utility>

#include "cli/interrupt.h"
#include "common/image/image_file.h"

namespace parray {

Preview::Preview(std::filesystem::path file) : file_(std::move(file)) {
  if (wanted()) check_image_path(file_);
}

void Preview::follow(Time now, Client& client, const JobStatus& status) {
  if (!wanted() || status.ended() || now < next_) return;
  began_ = began_.value_or(now);
  if (!status.whole && (status.progress == 0 || now - *began_ < seconds(1))) return;
  const SteadyClock clock;
  const Time begin = clock.now();
  write_image(file_, client.fetch_partial(status.id), {{"parray:partial", "true"}}, {},
              check_interrupted);
  const Time took = clock.now() - begin;
  next_ = now + std::max(10 * took, Time(milliseconds(500)));
}

}  // namespace parray
