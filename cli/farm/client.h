#pragma once

#include <cstdint>
#include <deque>
#include <exception>
#include <functional>
#include <map>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "cli/output/picture/picture.h"
#include "common/adaptive/error_estimate.h"
#include "coordinator/loop/limits.h"
#include "coordinator/store/job_record.h"
#include "proto/link.h"
#include "proto/messages.h"

namespace parray::farm {

/// A scene with its settings, as a client submits it.
struct Submission : JobHead {
  std::shared_ptr<const Scene> scene;
};

/// Returns the message that submits a scene, without token and user.
msg::Submit submit_message(Submission submission);

/// The coordinator's description of a job: the job map of PROTOCOL.md.
struct JobStatus {
  JobId id = 0;
  std::string name;
  std::string user;            ///< owner of the job's key; without keys, the client's user
  std::string state;           ///< name of a JobState: "queued", "running", "done" ...
  std::uint64_t priority = 0;  ///< 0 to 100
  double progress = 0;         ///< 0 to 1
  double samples_per_second = 0;
  double seconds_left = -1;       ///< estimated seconds until it ends; -1: unknown
  std::string reason;             ///< why the job failed, was cancelled or is paused
  std::string waits_for;          ///< what the job waits for; empty: nothing
  std::uint64_t queue_place = 0;  ///< 1: begins next; 0: not in the queue
  double starts_in = -1;          ///< estimated seconds until it begins; -1: unknown
  std::string warning;            ///< says that the job will take very long; empty: it will not
  /// Faults of results or of the picture file that were corrected, or checks that were impossible.
  /// Empty: none.
  std::string flag;
  std::uint64_t width = 0;
  std::uint64_t height = 0;
  std::uint64_t samples_per_pixel = 0;  ///< the limit; 0: none
  double samples_taken = 0;             ///< mean of the samples per pixel
  bool whole = false;                   ///< every pixel has a sample
  std::string sampler;
  std::uint64_t frames = 0;  ///< number of frames of a series; 0: the job is not a series
  std::uint64_t frames_done = 0;
  ErrorFigures error{};          ///< of the complete passes, or of the finished picture
  double target_error = 0;       ///< 0: none
  double target_half_width = 0;  ///< 0: none
  bool denoise = false;          ///< its finished pictures are denoised when they are written
  bool drawn = false;            ///< JobHead::drawing is drawn on its finished 8-bit pictures

  /// Returns whether the job is done, failed or cancelled.
  [[nodiscard]] bool ended() const;
};

/// Parses a job map. Throws RunError for any other map.
JobStatus job_status(const nlohmann::json& map);

/// Returns `work`, which reads maps of the coordinator's answers. If one of them lacks something,
/// `work` throws nlohmann::json::exception, and the returned function RunError.
std::function<int()> reading_answers(std::function<int()> work);

/// A client of PROTOCOL.md, over any link. A request is sent repeatedly until its answer comes.
/// Only start_submit() does not wait for the answer.
///
/// If the coordinator answers `error`, a request throws InputError, NoRoom or RunError with the
/// coordinator's text. If the coordinator has never answered this client, a request throws RunError
/// after Options::timeout. Not thread-safe.
class Client {
 public:
  struct Options {
    /// The address of the coordinator, for messages.
    std::string address;
    /// Another possible cause if the coordinator never answers, for messages.
    std::string silence_hint{};
    /// Interval between repetitions of a request. Requests with bulk data wait longer, by 1 s for
    /// every 10 MB.
    Time repeat = milliseconds(500);
    /// A coordinator that has never answered is given up after this time. Time during which this
    /// process was stopped does not count. Requests with bulk data wait longer, by 10 s for every
    /// 10 MB.
    Time timeout = seconds(10);
    /// Called at least every 50 ms while waiting. An exception ends the request.
    std::function<void()> poll = [] {};
    /// Called once for each request, with a text, if a coordinator that has answered before stops
    /// answering. The client waits for such a coordinator without a limit.
    std::function<void(const std::string&)> on_silence = [](const std::string&) {};
  };

  /// `link` and `clock` must outlive the client.
  Client(Link& link, const Clock& clock, Options options);

  /// Submits a scene and returns the number of the new job. Lost and repeated messages make only
  /// one job. Throws NoRoom if the coordinator has no room now.
  JobId submit(Submission submission);

  /// Sends a submission without waiting; take_outcome() returns the answer. The coordinator must
  /// have answered an earlier request. Lost and repeated messages make only one job.
  void start_submit(Submission submission);
  /// The answer to a submission of start_submit().
  struct Outcome {
    Submission submission;       ///< the submission, for a retry
    JobId job = 0;               ///< 0: refused
    std::exception_ptr refusal;  ///< what submit() would throw; null: accepted
  };
  /// Waits for an answer to any submission, at most `most`. Returns nothing if there is no answer,
  /// or if no submission waits for one.
  std::optional<Outcome> take_outcome(Time most);
  /// Returns the number of submissions whose outcome take_outcome() has not returned.
  [[nodiscard]] std::size_t submitting() const { return in_flight_.size() + outcomes_.size(); }
  /// Returns the bytes of the scenes of those submissions that have no answer yet.
  [[nodiscard]] std::uint64_t submitting_bytes() const { return bytes_in_flight_; }

  /// Returns the job map of PROTOCOL.md.
  nlohmann::json show(JobId job);
  /// Returns the map of a series with `frame_list`: at most 1000 frames from this number on.
  nlohmann::json show_series(JobId series, std::uint32_t from_frame);
  /// Changes a job and returns its map. `priority`: 0 to 100, for JobAction::prioritise.
  nlohmann::json steer(JobId job, msg::JobAction action, std::uint32_t priority = 0);
  /// Changes many jobs. Returns the list `results` of PROTOCOL.md, in the order of `jobs`.
  nlohmann::json steer(const std::vector<JobId>& jobs, msg::JobAction action,
                       std::uint32_t priority = 0);
  /// Returns job maps with their total number. `wanted`: which jobs, in which order.
  msg::Jobs list(msg::ListJobs wanted);
  /// These two return lists of the maps of PROTOCOL.md, with at most msg::most_listed entries. If
  /// there are more jobs, the list has the newest ones.
  nlohmann::json jobs();
  nlohmann::json workers();
  /// Returns the map of one worker, with its history and its recent failures. Throws InputError if
  /// no worker of this name is connected.
  nlohmann::json worker(const std::string& name);
  /// Returns the last lines of a worker's log, oldest first. Throws InputError if no worker of this
  /// name is connected, RunError if it does not answer.
  std::vector<std::string> worker_log(const std::string& name);
  /// Changes the worker `name` or, if `host`, all workers of the host `name`. Returns the maps of
  /// all connected workers of this name or host.
  nlohmann::json steer_workers(msg::WorkerAction action, const std::string& name, bool host);
  /// Fetches the picture of a job that is done, and checks its SHA-256.
  Picture fetch(JobId job, PictureDetail detail = PictureDetail::image);
  /// Fetches the picture of a job as it is now. Its report has `partial` and `samples`, if the job
  /// is not done.
  Picture fetch_partial(JobId job);

  /// The scene of a job and its settings.
  struct JobScene {
    Boxed<RenderSettings> settings;
    std::shared_ptr<const Scene> scene;
    std::string drawing;  ///< JobHead::drawing
  };
  /// Fetches the scene of a job that is not done, is denoised or has a drawing. Throws InputError
  /// for other jobs, and for jobs of other users unless this user is an administrator.
  JobScene scene(JobId job);

  /// The journal of a job; see coordinator/jobs/journal.h.
  struct JobJournal {
    nlohmann::json job;     ///< the job map
    nlohmann::json report;  ///< of a job that is done; otherwise empty
    std::string journal;    ///< encoded; read_journal() decodes it
  };
  /// Returns the journal of a job with its map and report.
  JobJournal journal(JobId job);

  /// Waits for `duration`. Calls options.poll and receives answers to submissions meanwhile.
  void rest(Time duration);

 private:
  template <typename Answer, typename Request>
  Answer ask(Request request, std::uint64_t bulk_bytes = 0);
  template <typename Answer>
  std::optional<Answer> take_answer();
  void receive_outcomes();
  bool note_outcome(const Message& message);
  void repeat_submits(Time now);
  void wait_a_little(Time most);
  /// Measures how long the coordinator has not answered.
  struct Silence {
    Time last{};            ///< when `waited` was updated
    Time waited{};          ///< time without an answer
    bool reported = false;  ///< the user knows
  };
  void find_coordinator();
  void note_silence(Silence& silence, Time timeout);
  [[nodiscard]] std::string silence_text() const;

  Link& link_;
  const Clock& clock_;
  const Options options_;
  std::uint64_t request_ = 0;  ///< number of the latest request
  bool answered_ = false;      ///< the coordinator has answered some request
  std::string unreadable_;     ///< why the latest message could not be decoded, and the remedy
  struct SentSubmission {
    Submission submission;
    Envelope message;
    std::uint64_t bytes = 0;
    Time repeat_at{};
  };
  std::map<std::uint64_t, SentSubmission> in_flight_;  ///< by number of the request
  std::uint64_t bytes_in_flight_ = 0;
  std::deque<Outcome> outcomes_;
  Silence submit_silence_;
};

}  // namespace parray::farm
