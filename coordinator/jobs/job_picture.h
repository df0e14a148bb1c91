#pragma once

#include <cstdint>
#include <memory>
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

namespace parray::coordinator {

/// The facts about a scene that the coordinator needs.
struct SceneFacts {
  explicit SceneFacts(const Scene& scene);
  Requirements requirements;
  double largest_radiance;  ///< see common/scene/largest_radiance.h
};

/// The unfinished picture of a job: framebuffer, passes, the merged cells of the current pass, and
/// the entries of the log from which a later process resumes. Both transports use it.
///
/// Not thread-safe.
class JobPicture {
 public:
  /// `settings`: after resolve_settings(). `begun`: samples of each pass that earlier processes
  /// began. `tile`: see WorkPlan. `large_pages`: see Framebuffer. `judge`: see PassController.
  JobPicture(const RenderSettings& settings, const SceneFacts& scene,
             std::vector<std::uint64_t> begun = {}, std::uint32_t tile = 0, bool large_pages = true,
             PictureJudge judge = {});

  /// Calls Framebuffer::touch(), for pictures with a time limit.
  void touch(std::size_t part, std::size_t parts) { framebuffer_.touch(part, parts); }

  /// Begins the first pass, or the next pass when all cells of the current one are merged. Returns
  /// false if the picture is complete.
  bool begin_pass(const PassTimes& times = {});

  /// What retract() changed.
  struct Retraction {
    /// Cells to trace again: none if the tracer traced nothing, all of the first pass after a
    /// restart.
    std::vector<CellRange> cells;
    bool restarted = false;  ///< the picture began again from its first pass
    std::vector<ResultCollector::Unchecked> unchecked;  ///< still merged; the tracer checked them
  };
  /// Removes the cells that `tracer` has traced, because it returned wrong bits. A picture in
  /// passes restarts, because the wrong sums have influenced its passes, unless the tracer has only
  /// checked cells of the current pass.
  Retraction retract(TracerKey tracer);
  /// Returns the share, 0 to 1, of the merged cells that were traced twice with equal bits.
  [[nodiscard]] double checked_share() const;
  /// Returns whether `tracer` has traced or checked cells in this pass or an earlier one.
  [[nodiscard]] bool relies_on(TracerKey tracer) const;

  /// Returns the log entry of merged cells. `packed`: the output of pack_cells().
  [[nodiscard]] std::string cells_entry(TracerKey tracer, const CellRange& range,
                                        std::string_view packed) const {
    return cells_entry(passes_->pass(), tracer, range, packed);
  }
  /// Does the same for any pass.
  static std::string cells_entry(std::uint32_t pass, TracerKey tracer, const CellRange& range,
                                 std::string_view packed);
  /// Returns the log entry of retract(), or of a call of the collector's note_check() or
  /// note_wanted().
  [[nodiscard]] std::string check_entry(TracerKey tracer, const CellRange& range) const;
  [[nodiscard]] std::string wanted_entry(const CellRange& range) const;
  [[nodiscard]] std::string retraction_entry(const std::vector<CellRange>& cells) const;
  /// Adds an entry to the journal. Returns its log entry.
  std::string journal_entry(const JournalEntry& entry);
  [[nodiscard]] const Journal& journal() const { return journal_; }
  /// Notes that the present samples are those of earlier processes, so that they do not count for
  /// the speed of tracing. Call it after the last replay().
  void end_replay() { passes_->begin_timing(framebuffer_); }
  /// Applies a log entry of an earlier process. Entries must come in the order of their writing.
  /// Begins their passes. Throws DecodeError.
  void replay(std::string_view entry);

  /// Returns whether a pass has begun. Before that, collector() and plan() must not be called.
  [[nodiscard]] bool has_begun() const { return collector_ != nullptr; }
  [[nodiscard]] const RenderSettings& settings() const { return settings_; }
  [[nodiscard]] const SceneFacts& scene() const { return scene_; }
  [[nodiscard]] const Framebuffer& framebuffer() const { return framebuffer_; }
  [[nodiscard]] const PassController& passes() const { return *passes_; }
  /// Collects the results of the current pass. Tracers are the machine_key() of a worker and the
  /// tracer_key() of a rank.
  [[nodiscard]] ResultCollector& collector() { return *collector_; }
  [[nodiscard]] const ResultCollector& collector() const { return *collector_; }
  /// Returns the plan of the current pass.
  [[nodiscard]] const std::shared_ptr<const WorkPlan>& plan() const { return collector_->plan(); }
  /// Estimates the error of the picture as it is now.
  [[nodiscard]] ErrorEstimate error() const;
  [[nodiscard]] FramebufferView view() const { return framebuffer_.view(scene_.largest_radiance); }

  /// Returns the most bytes of memory that such a picture needs until its report is made.
  static std::uint64_t memory(const RenderSettings& settings);

 private:
  Boxed<RenderSettings> settings_;
  SceneFacts scene_;
  std::uint32_t tile_;
  PictureJudge judge_;
  Framebuffer framebuffer_;
  std::unique_ptr<PassController> passes_;
  std::unique_ptr<ResultCollector> collector_;  ///< of the current pass; null before the first
  std::set<TracerKey> earlier_tracers_;         ///< tracers and checkers of earlier passes
  std::uint64_t earlier_cells_ = 0;             ///< merged cells of earlier passes
  std::uint64_t earlier_checked_ = 0;           ///< checked cells of earlier passes
  Journal journal_;
};

/// Returns a number for a process of a worker (msg::Hello has `name` and `instance`) or for a rank
/// (rank_voices()). It depends only on the arguments.
TracerKey tracer_key(std::string_view name, std::string_view instance);

}  // namespace parray::coordinator
