#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <vector>

#include "coordinator/jobs/job_failures.h"
#include "coordinator/jobs/job_picture.h"
#include "coordinator/jobs/report.h"
#include "coordinator/leases/lease_table.h"
#include "coordinator/store/job_record.h"
#include "proto/payloads.h"

namespace parray::coordinator {

/// Where an unfinished job is.
enum class JobPhase : std::uint8_t {
  waiting,    ///< holds no memory for its picture
  preparing,  ///< the job_thread is making its picture, or its next pass
  tracing,    ///< has leases to grant, or granted
  finishing,  ///< the job_thread is making the image and the report
  ended
};

/// What a job has while its picture is under way. `picture` belongs to the job_thread once tracing
/// has begun; everything else to the loop.
struct JobWork {
  std::shared_ptr<JobPicture> picture;
  ScenePayload scene;
  std::shared_ptr<const WorkPlan> plan;  ///< of the pass under way
  std::uint32_t pass = 0;
  std::optional<LeaseTable> leases;
  std::uint64_t generation = 0;  ///< names this work among all that there has been
  std::uint32_t tasks = 0;       ///< in the job_thread, without which a pass cannot end

  Time started = never;      ///< first grant
  Time clock_began = never;  ///< of the time limit
  Time pass_began = never;
  Time pass_ended = never;    ///< all of it was in
  double deciding = 0;        ///< seconds that the latest decision on a pass has taken
  std::uint64_t samples = 0;  ///< merged
  std::uint64_t cells = 0;    ///< of this pass, merged
  bool whole = false;         ///< every pixel has a sample
  std::uint64_t expected_samples = 0;
  double price = 0;  ///< thread-seconds a sample, of the latest results; 0: not known yet

  std::set<WorkerId> contributors;
  RenderFacts facts;
  JobFailures failures;
  bool held = false;            ///< Job::pause_reason is that of a dispute
  std::uint64_t unchecked = 0;  ///< leases that were to be checked, and that nobody could check
};

/// A job as the coordinator keeps it.
struct Job {
  JobRecord record;
  JobPhase phase = JobPhase::waiting;
  ScenePayload scene;      ///< where no store keeps it
  Time submitted = never;  ///< in this life
  Time served = never;     ///< latest lease that was its regular turn; never: not counted yet
  Time granted = never;    ///< latest lease
  Epoch next_epoch = 1;
  std::uint64_t spheres = 0;
  std::unique_ptr<JobWork> work;    ///< null while waiting, and once ended
  std::string pause_reason;         ///< of a pause that ends by itself
  Time retry_at = never;            ///< of finishing, after a full disk
  PicturePayload picture;           ///< of a done job, where no store keeps it
  std::string journal;              ///< likewise
  std::uint64_t picture_bytes = 0;  ///< of both
  double kept_progress = 0;         ///< of an earlier life, until this one has taken it up
  ErrorFigures error;               ///< of the passes that are complete; of a done job the report's

  /// Bytes of memory that it has for no other reason than that somebody may ask for it.
  [[nodiscard]] std::uint64_t kept_bytes() const {
    return ended() ? picture_bytes + scene.size() : 0;
  }
  /// Samples to be traced yet, roughly.
  [[nodiscard]] double samples_left(Time now) const;

  [[nodiscard]] bool ended() const { return phase == JobPhase::ended; }
  [[nodiscard]] bool tracing() const { return phase == JobPhase::tracing; }
  /// As `show` names its state: what the record keeps, and what comes and goes.
  [[nodiscard]] std::string_view shown_state() const;
  /// 0: not known yet.
  [[nodiscard]] double samples_per_second(Time now) const;
  /// Share of the work that is done, 0 .. 1. Of a picture that has a target to meet nobody knows
  /// the end: 0 in its first pass, then as the error so far says. It may fall.
  [[nodiscard]] double progress(Time now) const;
  /// What passes under a time limit are sized by, once all of a pass is in.
  [[nodiscard]] PassTimes times(Time now) const;
};

/// The job map of PROTOCOL.md; `waits_for` says what an unfinished job lacks, if anything.
nlohmann::json job_summary(const Job& job, Time now, const std::string& waits_for);

}  // namespace parray::coordinator
