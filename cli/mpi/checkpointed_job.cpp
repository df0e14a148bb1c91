#include "cli/mpi/checkpointed_job.h"

#include <algorithm>
#include <chrono>
#include <utility>

#include "cli/output/text.h"
#include "common/base/bytes.h"
#include "common/base/error.h"
#include "common/scene/scene_bytes.h"
#include "common/scene/settings.h"
#include "coordinator/disputes/retraction.h"

namespace parray::mpi {
namespace {

namespace fs = std::filesystem;

constexpr const char* database_name = "parray.sqlite";

/// Largest size of buffered results. A short job stays below it and never uses the disk.
constexpr std::size_t most_held_bytes = std::size_t{1} << 28;
/// Size of the records that pack_next() packs.
constexpr std::size_t most_packed_bytes = std::size_t{1} << 23;

JobRecord record_of(const Submission& submission, const std::string& scene_bytes,
                    std::uint32_t tile) {
  JobRecord record;
  record.id = 1;
  record.name = submission.name;
  record.priority = submission.priority;
  record.settings = submission.settings;
  record.tile = tile;
  record.precision_reason = submission.precision_reason;
  record.duplicates_removed = submission.duplicates_removed;
  record.load_seconds = submission.load_seconds;
  record.reserved_seconds = submission.reserved_seconds;
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

}  // namespace

CheckpointedJob::CheckpointedJob(Submission submission, std::uint32_t tile, fs::path directory,
                                 bool named)
    : directory_(std::move(directory)),
      named_(named),
      scene_(std::move(submission.scene)),
      scene_bytes_(scene_to_bytes(*scene_)),
      record_(record_of(submission, scene_bytes_, tile)) {
  std::error_code ignored;
  if (fs::exists(directory_ / database_name, ignored)) {
    store_ = std::make_unique<DiskStore>(directory_);
    auto kept = store_->jobs();
    if (!std::any_of(kept.begin(), kept.end(), [this](JobRecord& job) { return resume(job); })) {
      store_.reset();  // the directory belongs to another program, which may use it
    }
  }
  picture_ = std::make_unique<JobPicture>(record_.settings, SceneFacts(*scene_), record_.passes,
                                          record_.tile);
  if (store_) {
    replay();
  }
  samples_before_ = picture_->framebuffer().counts().samples;
}

std::shared_ptr<const Scene> CheckpointedJob::copy_scene() const {
  return std::make_shared<const Scene>(scene_from_bytes(scene_bytes_));
}

bool CheckpointedJob::resume(JobRecord& kept) {
  if (!is_unfinished(kept.state) || !same_picture(record_, kept)) {
    record_.id = std::max(record_.id, kept.id + 1);
    return false;
  }
  // Saved results number their cells by the saved plan. Other settings may differ in each run.
  RenderSettings asked = record_.settings;
  asked.schedule = kept.settings->schedule;
  asked.row_order = kept.settings->row_order;
  asked.progressive = kept.settings->progressive;
  record_ = std::move(kept);
  record_.settings = asked;
  record_.state = JobState::queued;
  return true;
}

void CheckpointedJob::replay() {
  try {
    store_->each_rows(record_.id, [this](std::string_view entry) { picture_->replay(entry); });
  } catch (const DecodeError& error) {
    throw RunError(directory_.string() + ": the saved results of the job are damaged: " +
                   error.what() + ": run parray-coordinator --repair " + directory_.string());
  }
  const double now =
      std::chrono::duration<double>(std::chrono::system_clock::now().time_since_epoch()).count();
  for (const FaultFinding& finding : kept_findings(*store_).after(record_.fault_findings)) {
    retract_results(*picture_, store_.get(), record_, finding, now);
  }
  store_->put_job(record_);
  store_->commit();
}

double CheckpointedJob::progress(Time elapsed) const {
  const RenderSettings& s = record_.settings;
  if (!s.has_passes()) {
    const ResultCollector& collector = picture_->collector();
    return static_cast<double>(collector.done_cells()) /
           static_cast<double>(collector.plan().cells());
  }
  const std::uint64_t expected = picture_->passes().expected_samples();
  double share = 0;
  if (expected > 0) {
    share = static_cast<double>(picture_->framebuffer().counts().samples) /
            static_cast<double>(expected);
  }
  if (s.time_limit > 0) {
    share = std::max(share, to_seconds(elapsed) / s.time_limit);
  }
  return std::min(share, 1.0);
}

std::string CheckpointedJob::amount_text() const {
  const RenderSettings& s = record_.settings;
  if (!s.in_passes()) {
    return formatted("%.1f", 100 * progress(Time(0))) + " %";
  }
  const auto samples = static_cast<double>(picture_->framebuffer().counts().samples);
  return formatted("%.1f", samples / s.width / s.height) + " samples a pixel";
}

bool CheckpointedJob::begin_pass(const PassTimes& times) {
  if (picture_->has_begun() && !picture_->collector().done()) {
    return true;  // an earlier run has begun this pass
  }
  const bool begun = picture_->begin_pass(times);
  record_.passes = picture_->passes().begun();
  return begun;
}

void CheckpointedJob::keep(TracerKey tracer, TracedCells cells) {
  held_bytes_ += cells.records.size();
  held_.push_back({picture_->passes().pass(), tracer, picture_->plan()->grid(), std::move(cells)});
}

void CheckpointedJob::retract(const std::vector<CellRange>& cells) {
  held_.push_back({picture_->passes().pass(), {}, {}, {}, picture_->retraction_entry(cells)});
}

void CheckpointedJob::restart() {
  held_.clear();
  held_bytes_ = 0;
  samples_before_ = 0;
  record_.passes = picture_->passes().begun();
  if (store_) {
    store_->drop_rows(record_.id);
    commit();
  }
}

void CheckpointedJob::add_flag(const std::string& text) {
  record_.flag += (record_.flag.empty() ? "" : "; ") + text;
}

bool CheckpointedJob::buffer_full() const { return held_bytes_ > most_held_bytes; }

bool CheckpointedJob::pack_next() {
  if (held_.empty()) {
    return false;
  }
  open_store();
  for (std::size_t packed = 0; !held_.empty() && packed < most_packed_bytes;) {
    const Held held = std::move(held_.front());
    held_.pop_front();
    packed += held.cells.records.size();
    held_bytes_ -= held.cells.records.size();
    store_->append_rows(
        record_.id, held.grid ? JobPicture::cells_entry(held.pass, held.tracer, held.cells.range,
                                                        pack_cells(held.cells, *held.grid))
                              : held.retraction);
  }
  return true;
}

void CheckpointedJob::commit() {
  while (pack_next()) {
  }
  if (store_) {
    store_->put_job(record_);  // the job may have begun a pass
    store_->commit();
  }
}

void CheckpointedJob::open_store() {
  if (!store_) {
    store_ = std::make_unique<DiskStore>(directory_);
    store_->put_scene(record_.scene, scene_bytes_);
    store_->put_job(record_);
  }
}

void CheckpointedJob::keep_picture(const Picture& picture) {
  held_.clear();
  if (!named_) {
    return;
  }
  open_store();
  record_.state = JobState::done;
  record_.report = picture.report.dump();
  store_->put_picture(record_.id, picture_pieces(picture.image, picture.statistics));
  store_->put_job(record_);
  store_->drop_work(record_.id);
  store_->commit();
}

void CheckpointedJob::forget() {
  if (named_ || !store_) {
    return;
  }
  store_->drop_job(record_.id);
  store_->commit();
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
