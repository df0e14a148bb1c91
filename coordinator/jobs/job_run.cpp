#include "coordinator/jobs/job_run.h"

#include <spdlog/fmt/fmt.h>

#include <algorithm>
#include <nlohmann/json.hpp>
#include <utility>

#include "common/base/bytes.h"
#include "common/scene/settings.h"
#include "coordinator/disputes/machines.h"

namespace parray::coordinator {
namespace {

using nlohmann::json;

/// Largest size of buffered results. A short job stays below it and never uses the disk.
constexpr std::size_t most_held_bytes = std::size_t{1} << 28;
/// Size of the records that pack_next() packs.
constexpr std::size_t most_packed_bytes = std::size_t{1} << 23;

/// Returns a job's flag after a machine returned wrong bits.
std::string flag_of(const JobPicture::Retraction& retraction, const std::string& name) {
  if (retraction.restarted) {
    return fmt::format("worker '{}' returned wrong bits: the picture was started again", name);
  }
  std::uint64_t cells = 0;
  for (const CellRange& range : retraction.cells) cells += range.count();
  if (cells == 0) {
    return fmt::format(
        "worker '{}' returned wrong bits: the cells that it checked are checked again", name);
  }
  return fmt::format("worker '{}' returned wrong bits: {} cells were traced again", name, cells);
}

}  // namespace

double share_done(const RenderSettings& settings, const RunState& state, double elapsed) {
  const auto share = [](std::uint64_t part, std::uint64_t all) {
    return all == 0 ? 0 : static_cast<double>(part) / static_cast<double>(all);
  };
  if (!settings.has_passes()) return share(state.cells, state.plan->cells());
  const double of_time = settings.time_limit > 0 ? elapsed / settings.time_limit : 0;
  return std::min(std::max(share(state.samples, state.expected_samples), of_time), 1.0);
}

void JobRun::create_picture(const SceneFacts& scene, bool large_pages, PictureJudge judge) {
  picture_ = std::make_unique<JobPicture>(record_.settings, scene, record_.passes, record_.tile,
                                          large_pages, std::move(judge));
}

std::string JobRun::replay(OnDamage on_damage) {
  std::uint64_t sound = 0;
  std::string damage;
  const auto note_damage = [&](const std::exception& error) {
    if (on_damage == OnDamage::fail) throw;
    damage = error.what();
    if (on_damage == OnDamage::cut) store_->keep_rows(record_.id, sound);
  };
  try {
    if (store_ != nullptr) {
      store_->each_rows(record_.id, [&](std::string_view entry) {
        picture_->replay(entry);
        ++sound;
      });
    }
  } catch (const StorageFull&) {
    throw;
  } catch (const RunError& error) {
    note_damage(error);
  } catch (const DecodeError& error) {
    note_damage(error);
  }
  picture_->end_replay();
  samples_before_ = picture_->framebuffer().counts().samples;
  return damage;
}

bool JobRun::begin_pass(const PassTimes& times, std::optional<double> at) {
  const bool under_way = picture_->has_begun() && !picture_->collector().done();
  const bool begun = under_way || picture_->begin_pass(times);
  record_.passes = picture_->passes().begun();
  if (at) add_to_journal(entries_of_pass(*at));
  put_record();
  return begun;
}

/// Returns the entries for the begin of the current pass; none if the journal has them.
std::vector<JournalEntry> JobRun::entries_of_pass(double at) const {
  const std::uint32_t pass = picture_->passes().pass();
  if (picture_->journal().has_pass(pass)) return {};
  const WorkPlan& plan = *picture_->plan();
  return {JournalPass{pass, plan.cells(), at, grain_of(plan)},
          JournalGrid{pass, plan.grid()->shape()}};
}

ResultCollector::Taken JobRun::take(TracerKey tracer, const TracedCells& cells,
                                    std::string_view packed) {
  ResultCollector::Taken taken = picture_->collector().take(tracer, cells);
  if (store_ != nullptr) append(picture_->cells_entry(tracer, cells.range, packed));
  return taken;
}

void JobRun::keep(TracerKey tracer, TracedCells cells) {
  const std::size_t bytes = cells.records.size();
  held_bytes_ += bytes;
  held_.push_back({bytes, [pass = picture_->passes().pass(), grid = picture_->plan()->grid(),
                           tracer, kept = std::move(cells)] {
                     return JobPicture::cells_entry(pass, tracer, kept.range,
                                                    pack_cells(kept, *grid));
                   }});
}

void JobRun::note_check(TracerKey tracer, const CellRange& range) {
  picture_->collector().note_check(tracer, range);
  append(picture_->check_entry(tracer, range));
}

void JobRun::note_wanted(const CellRange& range) {
  picture_->collector().note_wanted(range);
  append(picture_->wanted_entry(range));
}

void JobRun::add_to_journal(const std::vector<JournalEntry>& entries) {
  for (const JournalEntry& entry : entries) append(picture_->journal_entry(entry));
}

std::optional<JobPicture::Retraction> JobRun::retract(const FaultFinding& finding, double at) {
  std::optional<JobPicture::Retraction> removed;
  record_.passes = picture_->passes().begun();
  record_.fault_findings = finding.number;
  if (picture_->relies_on(finding.machine)) {
    removed = picture_->retract(finding.machine);
    record_.flag = flag_of(*removed, finding.worker);
    if (removed->restarted) {
      drop_results();
      add_to_journal(entries_of_pass(at));
    } else {
      keep_retraction(removed->cells);
      add_to_journal({JournalRetraction{picture_->passes().pass(), at, removed->cells}});
    }
    samples_before_ = std::min(samples_before_, picture_->framebuffer().counts().samples);
  }
  put_record();
  return removed;
}

void JobRun::retract_faulty(double at) {
  const std::string note = store_ == nullptr ? "" : store_->note("workers");
  if (note.empty()) return;
  try {
    const json list = json::parse(note).value("convictions", json::array());
    for (const FaultFinding& one : FaultFindings::from_json(list).after(record_.fault_findings)) {
      retract(one, at);
    }
  } catch (const json::exception& error) {
    throw damaged_worker_note(error.what());
  }
}

void JobRun::keep_retraction(const std::vector<CellRange>& cells) {
  append(picture_->retraction_entry(cells));
}

void JobRun::drop_results() {
  clear_buffer();
  samples_before_ = 0;
  record_.passes = {};  // wrong bits influenced the earlier passes
  if (store_ != nullptr) store_->drop_rows(record_.id);
}

/// Adds an entry to the buffer or to the log.
void JobRun::append(std::string entry) {
  if (open_) {  // after the buffered results
    held_.push_back({0, [entry = std::move(entry)] { return entry; }});
  } else if (store_ != nullptr) {
    store_->append_rows(record_.id, std::move(entry));
  }
}

void JobRun::put_record() {
  if (store_ != nullptr) store_->put_job(record_);
}

bool JobRun::buffer_full() const { return held_bytes_ > most_held_bytes; }

bool JobRun::pack_next() {
  if (held_.empty()) return false;
  store_ = store_ == nullptr ? open_() : store_;
  for (std::size_t packed = 0; !held_.empty() && packed < most_packed_bytes;) {
    const Held held = std::move(held_.front());
    held_.pop_front();
    packed += held.bytes;
    held_bytes_ -= held.bytes;
    store_->append_rows(record_.id, held.pack());
  }
  return true;
}

void JobRun::clear_buffer() {
  held_.clear();
  held_bytes_ = 0;
}

void JobRun::commit() {
  while (pack_next()) {
  }
  put_record();
  if (store_ != nullptr) store_->commit();
}

void JobRun::finish(const Image& image, const PictureStatistics& statistics, std::string report,
                    std::string_view journal) {
  clear_buffer();
  record_.state = JobState::done;
  record_.reason.clear();
  record_.report = std::move(report);
  store_ = store_ == nullptr && open_ ? open_() : store_;
  if (store_ != nullptr) {
    std::vector<std::string_view> pieces = picture_pieces(image, statistics);
    if (!journal.empty()) pieces.push_back(journal);
    store_->put_picture(record_.id, pieces);
    put_record();
    store_->drop_work(record_.id);
  }
}

void JobRun::put(JobRecord record) {
  record.passes = std::move(record_.passes);
  record.fault_findings = std::max(record.fault_findings, record_.fault_findings);
  record_ = std::move(record);
  put_record();
}

RunState JobRun::state() const {
  const PassController& passes = picture_->passes();
  const Framebuffer& framebuffer = picture_->framebuffer();
  return {picture_->plan(),
          passes.pass(),
          record_.passes,
          picture_->collector().done_cells(),
          framebuffer.counts().samples,
          passes.expected_samples(),
          framebuffer.whole(),
          passes.error()};
}

}  // namespace parray::coordinator
