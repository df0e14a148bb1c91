#include "cli/output/preview.h"

#include <utility>

#include "common/image/image_file.h"

namespace parray {

bool PreviewPace::due(double elapsed, bool whole) const {
  constexpr double patience = 0.1;
  constexpr double shortest = 0.1;
  constexpr double share = 0.02;
  if (whole && !shown_whole_) return true;
  if (!latest_) return elapsed >= patience;
  return elapsed - *latest_ >= shortest && spent_ + latest_cost_ <= share * elapsed;
}

void PreviewPace::wrote(double elapsed, bool whole, double cost) {
  const bool first = !latest_ || (whole && !shown_whole_);
  spent_ += first ? 0 : cost;
  latest_cost_ = cost;
  latest_ = elapsed;
  shown_whole_ = shown_whole_ || whole;
}

Preview::Preview(std::filesystem::path file, std::function<void()> while_writing)
    : file_(std::move(file)), while_writing_(std::move(while_writing)) {}

void Preview::follow(const Clock& clock, const JobStatus& status,
                     const std::function<Image()>& partial) {
  const bool traced = status.whole || status.samples_per_second > 0;
  if (!wanted() || status.ended() || !traced) return;
  const Time begin = clock.now();
  began_ = began_.value_or(begin);
  if (!pace_.due(to_seconds(begin - *began_), status.whole)) return;
  write_preview(file_, partial(), while_writing_);
  const Time end = clock.now();
  pace_.wrote(to_seconds(end - *began_), status.whole, to_seconds(end - begin));
}

}  // namespace parray
