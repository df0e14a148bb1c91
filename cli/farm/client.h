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

#include "cli/output/picture/picture.h"
#include "common/adaptive/error_estimate.h"
#include "coordinator/loop/limits.h"
#include "coordinator/store/job_record.h"
#include "proto/link.h"
#include "proto/messages.h"

namespace parray::farm {

/// What a client sends to have a scene rendered.
struct Submission : JobHead {
  std::shared_ptr<const Scene> scene;
};

/// The message that hands it over; without a token, and the user who has sent it.
msg::Submit submit_message(Submission submission);

/// The job map of PROTOCOL.md, read.
struct JobStatus {
  JobId id = 0;
  std::string name;
  std::string user;  ///< whose key has submitted it; empty: there were no keys
  std::string state;
  std::uint64_t priority = 0;
  double progress = 0;  ///< 0 .. 1
  double samples_per_second = 0;
  double seconds_left = -1;  ///< -1: unknown
  std::string reason;        ///< of a job that failed, was cancelled or is paused
  std::string waits_for;     ///< what it lacks; empty: nothing
  std::string flag;          ///< what was found wrong with its results, and mended
  std::uint64_t width = 0;
  std::uint64_t height = 0;
  std::uint64_t samples_per_pixel = 0;
  bool whole = false;  ///< every pixel has a sample
  std::string sampler;
  std::uint64_t frames = 0;  ///< of a series; 0: it is none
  std::uint64_t frames_done = 0;
  ErrorFigures error{};          ///< of the passes that are complete; of a done job its picture's
  double target_error = 0;       ///< 0: none
  double target_half_width = 0;  ///< 0: none

  /// Done, failed or cancelled: nothing more will happen.
  [[nodiscard]] bool ended() const;
};

/// Throws RunError when the map is not that of a job.
JobStatus job_status(const nlohmann::json& map);

/// A client's side of PROTOCOL.md, over any link: one request after the other, each repeated until
/// it is answered.
///
/// Every request throws InputError or RunError with the coordinator's words when it answers
/// `error`, and RunError when it does not answer. One thread.
class Client {
 public:
  struct Options {
    /// Of the coordinator, for messages.
    std::string address;
    /// What else may be the cause where it has never answered, for people.
    std::string silence_hint{};
    /// How often a request is repeated. What carries bulk waits longer, by 1 s for every 10 MB.
    Time repeat = milliseconds(500);
    /// Without an answer for this long a coordinator that has never answered is given up. Time
    /// during which this process was stopped does not count. Bulk: longer by 10 s for every 10 MB.
    Time timeout = seconds(10);
    /// Called at least every 50 ms while waiting; what it throws ends the request.
    std::function<void()> poll = [] {};
    /// A coordinator that has answered once is waited for, however long it takes: is told once that
    /// there is no answer, with a line for people.
    std::function<void(const std::string&)> on_silence = [](const std::string&) {};
  };

  /// `link` and `clock` must outlive the client.
  Client(Link& link, const Clock& clock, Options options);

  /// Returns the new job's number. Safe to lose and repeat on the way: it makes one job. Throws
  /// NoRoom where it may be tried again later.
  JobId submit(Submission submission);

  /// Sends a submission without waiting for its answer: take_outcome() returns that. The caller
  /// knows from an earlier request that the coordinator is there. Safe to lose and repeat, too.
  void start_submit(Submission submission);
  /// What came of a submission that start_submit() has sent.
  struct Outcome {
    Submission submission;       ///< for another try
    JobId job = 0;               ///< 0: it was refused
    std::exception_ptr refusal;  ///< what submit() would have thrown; null: none
  };
  /// Waits `most` at most for an answer to any of them. None: there was none, or nothing is under
  /// way.
  std::optional<Outcome> take_outcome(Time most);
  /// Submissions without an outcome yet, and the bytes of their scenes.
  [[nodiscard]] std::size_t submitting() const { return under_way_.size() + outcomes_.size(); }
  [[nodiscard]] std::uint64_t submitting_bytes() const { return under_way_bytes_; }

  /// The job map of PROTOCOL.md.
  nlohmann::json show(JobId job);
  /// Of a series, with `frame_list`, at most 1000 frames from this number on.
  nlohmann::json show_series(JobId series, std::uint32_t from_frame);
  /// Answered with the job map, too. `priority`: 0 .. 100, of JobAction::prioritise.
  nlohmann::json steer(JobId job, msg::JobAction action, std::uint32_t priority = 0);
  /// Lists of the maps of PROTOCOL.md.
  nlohmann::json jobs();
  nlohmann::json workers();
  /// Of a worker by name, or all of a host. Answered with the maps of those that are there.
  nlohmann::json steer_workers(msg::WorkerAction action, const std::string& name, bool host);
  /// The picture of a job that is done; its SHA-256 is checked.
  Picture fetch(JobId job, PictureDetail detail = PictureDetail::image);
  /// What there is of the picture of a job that may not be done.
  Image fetch_partial(JobId job);

  /// What has been merged into a job's picture; see coordinator/jobs/journal.h.
  struct JobJournal {
    nlohmann::json job;
    nlohmann::json report;  ///< of a job that is done; else empty
    std::string journal;
  };
  JobJournal journal(JobId job);

  /// Sleeps, with options.poll called.
  void rest(Time duration);

 private:
  template <typename Answer, typename Request>
  Answer ask(Request request, std::uint64_t bulk_bytes = 0);
  template <typename Answer>
  bool take_answer(Answer& answer);
  void receive_outcomes();
  bool note_outcome(const Message& message);
  void repeat_submits(Time now);
  void wait_a_little(Time most);
  /// How long there has been no answer.
  struct Silence {
    Time last{};
    Time waited{};
    bool told = false;
  };
  void note_silence(Silence& silence, Time timeout);
  [[nodiscard]] std::string silence_text() const;

  Link& link_;
  const Clock& clock_;
  const Options options_;
  std::uint64_t request_ = 0;  ///< number of the latest request
  bool answered_ = false;      ///< the coordinator has, to some request
  std::string unreadable_;     ///< why the latest message could not be decoded
  struct UnderWay {
    Submission submission;
    Envelope message;
    std::uint64_t bytes = 0;
    Time repeat_at{};
  };
  std::map<std::uint64_t, UnderWay> under_way_;  ///< by number of the request
  std::uint64_t under_way_bytes_ = 0;
  std::deque<Outcome> outcomes_;
  Silence submit_silence_;
};

}  // namespace parray::farm
