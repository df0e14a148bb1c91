#include "cli/output/preview.h"

#include <utility>

#include "cli/output/picture/image_file.h"

namespace parray::output {

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

Preview::Preview(const ProgressOptions& options, std::function<void()> while_writing)
    : file_(options.preview), while_writing_(std::move(while_writing)) {
  if (!options.display.empty()) display_ = std::make_unique<Display>(options.display);
}

void Preview::follow(const Clock& clock, const JobStatus& status,
                     const std::function<Image()>& partial) {
  const bool traced = status.whole || status.samples_per_second > 0;
  if (!wanted() || status.ended() || !traced) return;
  const Time begin = clock.now();
  began_ = began_.value_or(begin);
  if (!pace_.due(to_seconds(begin - *began_), status.whole)) return;
  Image image = partial();
  if (!file_.empty()) write_preview(file_, image, while_writing_);
  if (display_) display_->show(std::move(image), name_ = status.name);
  const Time end = clock.now();
  pace_.wrote(to_seconds(end - *began_), status.whole, to_seconds(end - begin));
}

void Preview::finish(const Image& image) {
  if (!display_ || name_.empty()) return;
  display_->show(image, name_);
  display_->finish(std::chrono::seconds(2));
}

}  // namespace parray::output
