#include "cli/mpi/kept_job.h"

#include <algorithm>
#include <span>
#include <utility>

#include "cli/text.h"
#include "common/base/error.h"
#include "common/scene/scene_bytes.h"
#include "proto/messages.h"

namespace parray {
namespace {

namespace fs = std::filesystem;

constexpr const char* database_name = "parray.sqlite";

/// Of finished rows that wait for the disk, so that a short job never asks it.
constexpr std::size_t most_held_bytes = std::size_t{1} << 28;

bool unfinished(const JobRecord& record) {
  return record.state == JobState::queued || record.state == JobState::running;
}

}  // namespace

KeptJob::KeptJob(Submission submission, fs::path directory, bool named)
    : directory_(std::move(directory)), named_(named) {
  JobRecord& record = job_.record;
  record.id = 1;
  record.name = submission.name;
  record.priority = submission.priority;
  record.settings = submission.settings;
  record.precision_reason = submission.precision_reason;
  record.duplicates_removed = submission.duplicates_removed;
  record.load_seconds = submission.load_seconds;
  record.scene = scene_identity(submission.scene_bytes);
  record.token = "mpi " + record.scene;
  std::error_code ignored;
  if (fs::exists(directory_ / database_name, ignored)) {
    store_ = std::make_unique<SqliteStore>(directory_);
    for (JobRecord& kept : store_->jobs()) {
      if (unfinished(kept) && same_picture(kept)) {
        const RenderSettings asked = record.settings;
        record = std::move(kept);
        // What is kept counts rows in its own order; all else may differ from run to run.
        const RowOrder order = record.settings.row_order;
        record.settings = asked;
        record.settings.row_order = order;
        job_.take_up(*store_);
        store_->commit();
        taken_up_ = job_.progress(Time{});
        next_epoch_ = job_.first_epoch();
        return;
      }
      record.id = std::max(record.id, kept.id + 1);
    }
    store_.reset();  // whoever it belongs to may go on using it
  }
  job_.start_work(std::make_shared<const std::string>(std::move(submission.scene_bytes)));
  next_epoch_ = job_.first_epoch();
}

bool KeptJob::same_picture(const JobRecord& kept) const {
  const RenderSettings& a = job_.record.settings;
  const RenderSettings& b = kept.settings;
  return kept.scene == job_.record.scene && a.width == b.width && a.height == b.height &&
         a.samples_per_pixel == b.samples_per_pixel && a.max_depth == b.max_depth &&
         a.seed == b.seed && a.sampler == b.sampler && a.precision == b.precision &&
         a.adaptive == b.adaptive && a.target_error == b.target_error &&
         a.target_half_width == b.target_half_width && a.time_limit == b.time_limit &&
         a.passes == b.passes;
}

void KeptJob::open_store() {
  if (store_) {
    return;
  }
  store_ = std::make_unique<SqliteStore>(directory_);
  store_->put_scene(job_.record.scene, *job_.work->scene_bytes);
  store_->put_job(job_.record);
}

void KeptJob::keep(const RowBlock& block) {
  if (closed_) {
    return;
  }
  held_.push_back(row_block_to_bytes(block));
  held_bytes_ += held_.back().size();
  if (held_bytes_ > most_held_bytes) {
    put_held();
  }
}

void KeptJob::put_held() {
  open_store();
  if (std::exchange(new_pass_, false)) {
    store_->put_job(job_.record);
  }
  for (const std::string& block : held_) {
    store_->put_block(job_.record.id, next_epoch_++, block);
  }
  held_.clear();
  held_bytes_ = 0;
}

void KeptJob::commit() {
  if (!held_.empty()) {
    put_held();
  }
  if (store_) {
    store_->commit();
  }
}

bool KeptJob::next_pass(Time now) {
  job_.note_all_merged();
  new_pass_ = job_.next_pass(now);
  return new_pass_;
}

std::string KeptJob::amount_text(double share) const {
  const RenderSettings& s = job_.record.settings;
  if (!s.in_passes()) {
    return formatted("%.1f", 100 * share) + " %";
  }
  const auto samples = static_cast<double>(job_.work->framebuffer.counts().samples);
  return formatted("%.1f", samples / s.width / s.height) + " samples a pixel";
}

void KeptJob::keep_picture(const Picture& picture) {
  if (!named_) {
    return;
  }
  held_.clear();
  open_store();
  job_.record.state = JobState::done;
  job_.record.report = picture.report.dump();
  store_->put_picture(job_.record.id, picture_to_bytes(picture.image, picture.statistics));
  store_->put_job(job_.record);
  store_->drop_work(job_.record.id);
  store_->commit();
}

void KeptJob::forget() {
  if (named_ || !store_) {
    return;
  }
  store_.reset();
  std::error_code ignored;
  for (const char* suffix : {"", "-wal", "-shm"}) {
    fs::remove(directory_ / (std::string(database_name) + suffix), ignored);
  }
  fs::remove(directory_, ignored);  // unless somebody has put something else there
}

}  // namespace parray
