#pragma once

#include <memory>
#include <nlohmann/json.hpp>
#include <set>
#include <string>

#include "common/image/framebuffer.h"
#include "common/image/picture_bytes.h"
#include "common/scene/requirements.h"
#include "coordinator/lease_table.h"
#include "coordinator/store.h"

namespace parray {

/// Work in progress of one job: present while it is queued or running.
struct JobWork {
  JobWork(const RenderSettings& settings, Epoch first_epoch)
      : leases(settings, first_epoch), framebuffer(settings) {}

  LeaseTable leases;
  Framebuffer framebuffer;
  std::shared_ptr<const std::string> scene_bytes;
  Requirements requirements;
  double largest_radiance = 1;
  Time started = never;    ///< first grant
  std::size_t passes = 0;  ///< begun
  Time pass_began = never;
  std::uint64_t samples_before_pass = 0;
  std::uint64_t expected_samples = 0;  ///< of the finished picture; 0: unknown
  StopReason stopped_by = StopReason::samples;
  std::set<WorkerId> contributors;
  std::uint32_t contributor_threads = 0;
  double build_seconds = 0;             ///< the longest of any worker
  std::uint64_t accelerator_bytes = 0;  ///< the largest of any worker
  std::string isa;
};

/// A job as the coordinator keeps it.
struct Job {
  JobRecord record;
  std::unique_ptr<JobWork> work;  ///< null once done, failed or cancelled

  [[nodiscard]] bool open() const { return work != nullptr; }
  /// All of the job's samples are pending, or those of its first pass. Throws DecodeError when the
  /// bytes are no scene.
  void start_work(std::shared_ptr<const std::string> scene_bytes);
  /// Begins another life of a job that `store` has kept: merges what earlier ones have finished;
  /// the rest is pending: nothing only if the picture is complete. Throws when what is kept is
  /// damaged.
  void take_up(Store& store);
  /// When all work is done: adds the next pass, for the store to remember, or finds that there is
  /// none; then the picture is complete.
  bool next_pass(Time now);
  /// Marks all pending work as done: it has been merged, without leases of the table's.
  void note_all_merged();
  /// Whether every pixel has a sample.
  [[nodiscard]] bool whole() const;
  /// Share of the work that is done, 0 .. 1. Of a picture that has a target to meet nobody knows
  /// the end: 0 in its first pass, then as the error so far says. It may fall.
  [[nodiscard]] double progress(Time now) const;
  /// Epochs of every life are apart, so that a grant of an earlier one is never taken for current.
  [[nodiscard]] Epoch first_epoch() const { return (Epoch{record.life} << 32) + 1; }

 private:
  void begin_pass(std::uint64_t samples);
  [[nodiscard]] std::uint64_t affordable_samples(Time now) const;
};

/// The job map of PROTOCOL.md.
nlohmann::json job_summary(const Job& job, Time now);

/// A picture that is complete.
struct FinishedPicture {
  Image image;
  PictureStatistics statistics;
  /// Its fields are described in README.md, "The report". Everything but what the client adds
  /// (seconds spent writing).
  nlohmann::json report;
};
FinishedPicture finish_picture(const Job& job, Time finished);

}  // namespace parray
