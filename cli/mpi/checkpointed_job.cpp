#include "cli/mpi/checkpointed_job.h"

#include <algorithm>
#include <chrono>
#include <utility>

#include "cli/output/text.h"
#include "common/base/bytes.h"
#include "common/base/error.h"
#include "common/scene/scene_bytes.h"
#include "common/scene/settings.h"

namespace parray::mpi {
namespace {

namespace fs = std::filesystem;

constexpr const char* database_name = "parray.sqlite";

JobRecord record_of(const Submission& submission, const std::string& scene_bytes,
                    std::uint32_t tile) {
  JobRecord record;
  static_cast<JobHead&>(record) = submission;
  record.id = 1;
  record.tile = tile;
  record.scene = scene_identity(scene_bytes);
  record.scene_bytes = scene_bytes.size();
  record.token = "mpi " + record.scene.substr(0, 32);
  return record;
}

/// Returns whether two jobs have pictures with the same bits. Their plans may differ.
bool same_picture(const JobRecord& a, const JobRecord& b) {
  return a.scene == b.scene && a.settings->picture() == b.settings->picture() &&
         a.settings->stop() == b.settings->stop();
}

/// Replaces `record` by `kept` and returns true if `kept` is an unfinished job of the same picture.
/// Otherwise raises the number of `record` above that of `kept`, and returns false.
bool resume(JobRecord& record, JobRecord& kept) {
  if (!is_unfinished(kept.state) || !same_picture(record, kept)) {
    record.id = std::max(record.id, kept.id + 1);
    return false;
  }
  // Saved results number their cells by the saved plan. Other settings may differ in each run.
  RenderSettings asked = record.settings;
  asked.schedule = kept.settings->schedule;
  asked.row_order = kept.settings->row_order;
  asked.progressive = kept.settings->progressive;
  record = std::move(kept);
  record.settings = asked;
  record.state = JobState::queued;
  return true;
}

}  // namespace

CheckpointedJob::CheckpointedJob(Submission submission, std::uint32_t tile, fs::path directory,
                                 bool named)
    : directory_(std::move(directory)),
      named_(named),
      scene_(std::move(submission.scene)),
      scene_bytes_(scene_to_bytes(*scene_)) {
  JobRecord record = record_of(submission, scene_bytes_, tile);
  std::error_code ignored;
  if (fs::exists(directory_ / database_name, ignored)) {
    store_ = std::make_unique<DiskStore>(directory_);
    auto jobs = store_->jobs();
    if (std::ranges::none_of(jobs, [&](JobRecord& kept) { return resume(record, kept); })) {
      store_.reset();  // the directory belongs to another program, which may use it
    }
  }
  run_ = std::make_unique<JobRun>(std::move(record), store_.get(), [this] {
    store_ = std::make_unique<DiskStore>(directory_);
    store_->put_scene(run_->record().scene, scene_bytes_);
    store_->put_job(run_->record());
    return store_.get();
  });
  run_->create_picture(SceneFacts(*scene_));
  try {
    run_->replay(JobRun::OnDamage::fail);
  } catch (const DecodeError& error) {
    throw RunError(directory_.string() + ": the saved results of the job are damaged: " +
                   error.what() + ": run parray-coordinator --repair " + directory_.string());
  }
  run_->retract_faulty(
      std::chrono::duration<double>(std::chrono::system_clock::now().time_since_epoch()).count());
  run_->commit();
}

std::shared_ptr<const Scene> CheckpointedJob::copy_scene() const {
  return std::make_shared<const Scene>(scene_from_bytes(scene_bytes_));
}

std::string CheckpointedJob::amount_text() const {
  const RenderSettings& s = run_->record().settings;
  const RunState state = run_->state();
  if (!s.in_passes()) return formatted("%.1f", 100 * share_done(s, state, 0)) + " %";
  return formatted("%.1f", static_cast<double>(state.samples) / s.width / s.height) +
         " samples per pixel";
}

void CheckpointedJob::keep_picture(const Picture& picture) {
  run_->clear_buffer();
  if (named_) {
    run_->finish(picture.image, picture.statistics, picture.report.dump());
    run_->commit();
  }
}

void CheckpointedJob::forget() {
  if (named_ || !store_) return;
  store_->drop_job(run_->record().id);
  store_->commit();
  run_.reset();
  store_.reset();
  std::error_code ignored;
  for (const char* suffix : {"", "-wal", "-shm"}) {
    fs::remove(directory_ / (std::string(database_name) + suffix), ignored);
  }
  for (const char* name : {"jobs", "scenes", "reserve", "commits", ""}) {
    fs::remove(directory_ / name, ignored);  // fails if the directory contains other files
  }
}

}  // namespace parray::mpi
