#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <vector>

#include "common/adaptive/pass_controller.h"
#include "common/image/framebuffer.h"
#include "common/scene/requirements.h"
#include "common/scene/scene.h"
#include "common/scene/settings_fwd.h"
#include "coordinator/jobs/journal.h"
#include "coordinator/leases/result_collector.h"
#include "coordinator/store/store.h"

namespace parray::coordinator {

/// What the coordinator needs to know of a scene.
struct SceneFacts {
  explicit SceneFacts(const Scene& scene);
  Requirements requirements;
  double largest_radiance;
};

/// A job's picture under way: framebuffer, passes, what is in of the pass that is being traced, and
/// the log from which another life of the job goes on. The same under messages and over a window.
///
/// Plain state; one thread at a time.
class JobPicture {
 public:
  /// `settings` are resolved. `begun`: samples of the passes of earlier lives. `tile`: see
  /// WorkPlan. `large_pages`: see Framebuffer. `judge`: see PassController.
  JobPicture(const RenderSettings& settings, const SceneFacts& scene,
             std::vector<std::uint64_t> begun = {}, std::uint32_t tile = 0, bool large_pages = true,
             PictureJudge judge = {});

  /// See Framebuffer::touch(): for pictures whose passes are sized by the time they take.
  void touch(std::size_t part, std::size_t parts) { framebuffer_.touch(part, parts); }

  /// Begins the first or, when all of a pass is in, the next pass; false when the picture is
  /// complete.
  bool begin_pass(const PassTimes& times = {});

  /// Merges what `tracer`, a machine_key(), has traced of the current pass.
  ResultCollector::Taken take(TracerKey tracer, const TracedCells& traced) {
    return collector_->take(tracer, traced);
  }
  /// The same with the digests of its records and its cells at hand.
  ResultCollector::Taken take(TracerKey tracer, const TracedCells& traced,
                              std::vector<std::uint64_t> digests, std::span<const Cell> cells) {
    return collector_->take(tracer, traced, std::move(digests), cells);
  }

  /// Sets back what `tracer` has traced, because it returned wrong bits. A picture in passes starts
  /// all over again (`restarted`), because its sums decided what its passes are.
  struct Retraction {
    std::vector<CellRange> cells;  ///< to be traced again; none if it traced nothing
    bool restarted = false;
    std::vector<CellRange> unchecked;  ///< still in, but only `tracer` had checked them
  };
  Retraction retract(TracerKey tracer);
  /// Notes that `tracer` got the merged bits for the range, too.
  void note_check(TracerKey tracer, const CellRange& range) {
    collector_->note_check(tracer, range);
  }
  /// Share of the cells, 0 to 1, of all passes so far, that were traced twice with equal bits.
  [[nodiscard]] double checked_share() const;
  /// Returns whether `tracer` has traced or checked cells in this pass or an earlier one.
  [[nodiscard]] bool relies_on(TracerKey tracer) const;

  /// Entries of the job's log. The first is for cells as pack_cells() has them.
  [[nodiscard]] std::string cells_entry(TracerKey tracer, const CellRange& range,
                                        std::string_view packed) const {
    return cells_entry(passes_->pass(), tracer, range, packed);
  }
  /// The same of any pass.
  static std::string cells_entry(std::uint32_t pass, TracerKey tracer, const CellRange& range,
                                 std::string_view packed);
  [[nodiscard]] std::string check_entry(TracerKey tracer, const CellRange& range) const;
  [[nodiscard]] std::string retraction_entry(const std::vector<CellRange>& cells) const;
  /// Adds to the journal; returns the log's entry of it.
  std::string journal_entry(const JournalEntry& entry);
  [[nodiscard]] const Journal& journal() const { return journal_; }
  /// Everything of earlier lives is in.
  void end_replay() { passes_->begin_timing(framebuffer_); }
  /// Takes in an entry of an earlier life, in the order in which they were written; begins the
  /// passes that the entries belong to. Throws DecodeError.
  void replay(std::string_view entry);

  /// Whether there is a pass; without one there is no collector and no plan.
  [[nodiscard]] bool has_begun() const { return collector_ != nullptr; }
  [[nodiscard]] const RenderSettings& settings() const { return settings_; }
  [[nodiscard]] const SceneFacts& scene() const { return scene_; }
  [[nodiscard]] const Framebuffer& framebuffer() const { return framebuffer_; }
  [[nodiscard]] const PassController& passes() const { return *passes_; }
  [[nodiscard]] ResultCollector& collector() { return *collector_; }
  [[nodiscard]] const ResultCollector& collector() const { return *collector_; }
  /// Of the pass under way.
  [[nodiscard]] const std::shared_ptr<const WorkPlan>& plan() const {
    return collector_->shared_plan();
  }
  /// Of the picture as it is.
  [[nodiscard]] ErrorEstimate error() const;
  [[nodiscard]] FramebufferView view() const { return framebuffer_.view(scene_.largest_radiance); }

  /// Bytes that a picture of these settings takes at most while it is under way, ending included.
  static std::uint64_t memory(const RenderSettings& settings);

 private:
  void restart();

  Boxed<RenderSettings> settings_;
  SceneFacts scene_;
  std::uint32_t tile_;
  PictureJudge judge_;
  Framebuffer framebuffer_;
  std::unique_ptr<PassController> passes_;
  std::unique_ptr<ResultCollector> collector_;  ///< of the pass under way; null before the first
  std::set<TracerKey> earlier_tracers_;         ///< of the passes before, checkers included
  std::uint64_t earlier_cells_ = 0;             ///< likewise
  std::uint64_t earlier_checked_ = 0;           ///< likewise
  Journal journal_;
};

/// Adds entries to the picture's journal and, where there is a store, to the job's log.
void keep_journal(JobPicture& picture, Store* store, JobId id,
                  const std::vector<JournalEntry>& entries);
/// That the pass under way has begun, unless the journal knows.
std::vector<JournalEntry> begun_entries(const JobPicture& picture, double at);

/// Names whoever traces across lives of the coordinator: a process of a worker, or a rank.
TracerKey tracer_key(std::string_view name, std::string_view instance);

}  // namespace parray::coordinator
