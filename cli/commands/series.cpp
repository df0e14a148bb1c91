#include "cli/commands/series.h"

#include <unistd.h>

#include <algorithm>
#include <iostream>
#include <map>
#include <span>
#include <utility>

#include "cli/commands/rendering.h"
#include "cli/output/progress.h"
#include "common/base/error.h"
#include "common/base/printable.h"
#include "common/base/sha256.h"
#include "common/process/stop_signal.h"

namespace parray::commands {
namespace {

using nlohmann::json;

/// An entry of a series' `frame_list`.
struct ListedFrame {
  std::uint32_t frame = 0;
  JobId job = 0;
  std::string state;
  std::string reason;

  [[nodiscard]] bool done() const { return state == name_of(JobState::done); }
  [[nodiscard]] bool ended() const {
    return done() || state == name_of(JobState::failed) || state == name_of(JobState::cancelled);
  }
  [[nodiscard]] std::string why() const { return state + (reason.empty() ? "" : ": " + reason); }
};

/// Throws InputError for a job that is no series, and json::exception for a damaged answer.
std::vector<ListedFrame> listed_frames(const json& map) {
  if (!map.contains("frame_list")) {
    throw InputError(
        "job " + map.value("id", json()).dump() +
        " is not a series of frames, so it has no frame numbers for #: give a file name without #");
  }
  std::vector<ListedFrame> frames;
  for (const json& entry : map["frame_list"]) {
    frames.push_back({entry.at("frame"), entry.at("job"),
                      printable(entry.at("state").get<std::string>()),
                      printable(entry.at("reason").get<std::string>(), 500)});
  }
  return frames;
}

/// Frames without a picture, and the reasons.
using Failures = std::map<std::uint32_t, std::string>;

int report_failures(const Failures& failures) {
  for (const auto& [frame, why] : failures) {
    std::cerr << "parray: frame " << frame << ": " << why << "\n";
  }
  return failures.empty() ? 0 : 1;
}

class FrameRun {
 public:
  FrameRun(Client& client, const FrameJobs& jobs)
      : client_(client),
        jobs_(jobs),
        progress_(progress_style(jobs.following.quiet || !jobs.wait, jobs.following.progress),
                  std::cerr, terminal_columns) {}

  int run() {
    if (in_series()) {
      find_earlier_frames();
    } else {
      (void)client_.workers();  // start_submit() needs a coordinator that has answered
    }
    for (const std::uint32_t frame : jobs_.frames) {
      if (known_.contains(frame) || jobs_.there.contains(frame)) continue;
      wait_while([this] { return unfinished() >= jobs_.most_unfinished; });
      if (auto submission = load(frame)) submit(std::move(*submission));
      update_if_due();
      check_not_cancelled();
    }
    settle(0);
    wait_while([this] { return jobs_.wait && !pending_.empty(); });
    progress_.make_way();
    if (jobs_.wait && series_ != 0) run_end();
    return std::max(report_failures(failures_), status_);
  }

  [[nodiscard]] JobId series() const { return series_; }

 private:
  [[nodiscard]] bool in_series() const { return !jobs_.token.empty(); }
  [[nodiscard]] std::size_t unfinished() const {
    return pending_.size() + client_.submitting() + refused_.size();
  }

  void wait_while(const auto& condition) {
    while (condition()) {
      settle(0);
      update();
      if (!condition()) return;
      const Time longest = in_series() ? milliseconds(100) : milliseconds(20);
      client_.rest(std::min(polling_interval(clock_.now() - begin_), longest));
    }
  }

  void find_earlier_frames() {
    for (const json& map : client_.jobs()) {
      if (map.value("frames", 0) == 0 || map.value("series", "") != jobs_.token) continue;
      set_series(map.at("id"));
      planned_ = map.at("frames");
    }
    for (std::uint32_t from = 0; series_ != 0;) {
      const auto frames = listed_frames(client_.show_series(series_, from));
      if (frames.empty()) break;
      for (const ListedFrame& frame : frames) {
        known_.insert(frame.frame);
        if (!jobs_.there.contains(frame.frame)) pending_.emplace(frame.frame, frame.job);
      }
      from = frames.back().frame + 1;
    }
    if (!known_.empty()) {
      std::cerr << "parray: series " << series_ << " continues: " << known_.size() << " of "
                << planned_ << " frames were submitted before\n";
    }
  }

  void set_series(JobId series) {
    series_ = series;
    if (jobs_.prints) std::cout << series << std::endl;
  }

  /// Loads a frame. Returns nothing if it cannot be submitted; failures_ then has the reason.
  std::optional<Submission> load(std::uint32_t frame) {
    try {
      Submission submission = jobs_.load(frame);
      submission.series = jobs_.token;
      submission.frame = frame;
      if (in_series()) submission.frames = planned_;
      return submission;
    } catch (const InputError& error) {
      const bool first = unfinished() == 0 && ended_ == 0 && failures_.empty();
      if (first && jobs_.first_must_load) throw;
      failures_[frame] = error.what();
      return {};
    }
  }

  /// Submits a frame. The first frame is submitted alone, because its answer has the number of the
  /// series. Later ones are submitted several at a time.
  void submit(Submission submission) {
    const bool first = in_series() && series_ == 0;
    settle(first ? 0 : most_in_flight - 1);
    client_.start_submit(std::move(submission));
    if (first) settle(0);
  }

  /// Waits until at most `most` submissions have no answer yet.
  void settle(std::size_t most) {
    while (client_.submitting() + refused_.size() > most ||
           client_.submitting_bytes() > most_bytes_in_flight || !refused_.empty()) {
      if (client_.submitting() == 0) retry_refused();
      if (auto outcome = client_.take_outcome(milliseconds(500))) handle(std::move(*outcome));
      update_if_due();
      check_not_cancelled();
    }
  }

  void handle(Client::Outcome outcome) {
    const std::uint32_t frame = outcome.submission.frame;
    try {
      if (outcome.refusal) std::rethrow_exception(outcome.refusal);
      if (in_series() && series_ == 0) set_series(client_.show(outcome.job).at("series"));
      pending_.emplace(frame, outcome.job);
    } catch (const NoRoom& error) {
      wait_for_room(std::move(outcome.submission), error.what());
    } catch (const InputError& error) {
      failures_[frame] = error.what();
    } catch (const RunError& error) {  // the coordinator's disk or memory is full
      wait_for_room(std::move(outcome.submission), error.what());
    }
  }

  /// Keeps a refused submission for later. Prints one line for all frames that wait for the same
  /// reason.
  void wait_for_room(Submission submission, const std::string& why) {
    const std::uint32_t frame = submission.frame;
    refused_.emplace(frame, std::move(submission));
    if (std::exchange(waits_for_, why) == why) return;
    progress_.make_way();
    std::cerr << "parray: frame " << frame << " waits: " << why << "\n";
  }

  /// Submits the refused frames again, in their order, after a pause.
  void retry_refused() {
    if (refused_.empty()) return;
    update();
    check_not_cancelled();
    client_.rest(milliseconds(500));
    for (auto& [frame, submission] : std::exchange(refused_, {})) {
      client_.start_submit(std::move(submission));
    }
  }

  void update_if_due() {
    if (clock_.now() >= next_update_) update();
  }

  /// Shows the progress of the series, and fetches the finished frames.
  void update() {
    next_update_ = clock_.now() + milliseconds(500);
    if (!in_series()) return update_jobs();
    if (series_ == 0) return;
    const json map = client_.show_series(series_, pending_.empty() ? 0 : pending_.begin()->first);
    const JobStatus status = job_status(map);
    progress_.show(clock_.now(), status);
    for (const ListedFrame& frame : listed_frames(map)) {
      if (frame.ended() && pending_.erase(frame.frame) > 0) handle_ended(frame);
    }
    cancelled_ = status.state == name_of(JobState::cancelled);
  }

  /// Does the same for frames that are jobs of their own.
  void update_jobs() {
    JobStatus all;
    for (const auto& [frame, job] : std::exchange(pending_, {})) {
      JobStatus status = job_status(client_.show(job));
      if (status.ended()) {
        handle_ended({frame, job, status.state, status.reason});
        continue;
      }
      pending_.emplace(frame, job);
      all.progress += status.progress;
      all.samples_per_second = std::max(all.samples_per_second, status.samples_per_second);
    }
    all.frames = jobs_.frames.size();
    all.frames_done = ended_ + jobs_.there.size();
    const double here = all.progress + static_cast<double>(ended_);
    const auto to_do = static_cast<double>(all.frames - jobs_.there.size());
    all.progress =
        (here + static_cast<double>(jobs_.there.size())) / static_cast<double>(all.frames);
    all.state = name_of(all.frames_done == all.frames ? JobState::done : JobState::running);
    if (here > 0) all.seconds_left = to_seconds(clock_.now() - begin_) * (to_do - here) / here;
    all.name = "film";
    progress_.show(clock_.now(), all);
  }

  void run_end() const {
    const bool done = failures_.empty();
    run_end_command(jobs_.following.on_end, series_,
                    std::string(name_of(done ? JobState::done : JobState::failed)),
                    done ? "" : failures_.begin()->second, jobs_.image);
  }

  void check_not_cancelled() const {
    if (cancelled_) {
      const std::string number = std::to_string(series_);
      throw RunError("series " + number + " was cancelled: use parray requeue " + number +
                     " to continue, or parray forget " + number + " to start again");
    }
  }

  /// Delivers a frame that is done, or notes why it failed.
  void handle_ended(const ListedFrame& frame) {
    ++ended_;
    if (!frame.done()) {
      failures_[frame.frame] = frame.why();
      return;
    }
    if (!jobs_.deliver) return;
    if (jobs_.prints) progress_.make_way();
    try {
      status_ = std::max(status_, jobs_.deliver(frame.frame, frame.job));
      if (!in_series()) client_.steer(frame.job, msg::JobAction::forget);
    } catch (const InputError& error) {
      failures_[frame.frame] = error.what();
    } catch (const RunError& error) {
      failures_[frame.frame] = error.what();
    }
  }

  /// Largest number of submissions without an answer: enough to share the coordinator's commits.
  static constexpr std::size_t most_in_flight = 64;
  /// Largest size of their scenes together. A larger scene is submitted alone.
  static constexpr std::uint64_t most_bytes_in_flight = std::uint64_t{1} << 25;

  Client& client_;
  const FrameJobs& jobs_;
  Progress progress_;
  SteadyClock clock_;
  Time begin_ = clock_.now();
  Time next_update_{};
  JobId series_ = 0;
  std::uint32_t planned_ = static_cast<std::uint32_t>(jobs_.frames.size() - jobs_.there.size());
  std::set<std::uint32_t> known_;                ///< submitted by an earlier run
  std::map<std::uint32_t, JobId> pending_;       ///< submitted, and not known to have ended
  std::map<std::uint32_t, Submission> refused_;  ///< the coordinator had no room for these frames
  std::string waits_for_;                        ///< the last reason that was printed
  Failures failures_;
  std::uint64_t ended_ = 0;  ///< frames that have ended during this run
  bool cancelled_ = false;
  int status_ = 0;
};

}  // namespace

OutputPaths outputs_of(const OutputPaths& outputs, std::uint32_t frame) {
  OutputPaths numbered = outputs;
  numbered.image = with_frame_number(outputs.image.string(), frame);
  numbered.report = with_frame_number(outputs.report.string(), frame);
  numbered.error_map = with_frame_number(outputs.error_map.string(), frame);
  return numbered;
}

void check_frame_outputs(const OutputPaths& outputs) {
  for (const auto& file : {outputs.image, outputs.report, outputs.error_map}) {
    if (!file.empty() && !has_frame_number(file.string())) {
      throw InputError(printable(file.string(), 4096) +
                       ": every frame needs its own file: write #### for the frame's number");
    }
  }
  check_outputs(outputs_of(outputs, 0));
}

std::string series_token(const std::string& request) {
  const std::string text = std::to_string(getuid()) + "\n" + request;
  constexpr std::size_t digits = 48;
  return sha256_hex(std::as_bytes(std::span(text))).substr(0, digits);
}

int run_frames(Client& client, const FrameJobs& jobs) {
  FrameRun run(client, jobs);
  try {
    return run.run();
  } catch (const Interrupted&) {
    throw Interrupted("interrupted: the same command continues" +
                      (run.series() == 0 ? std::string()
                                         : "; parray cancel " + std::to_string(run.series()) +
                                               " cancels the series"));
  }
}

int fetch_series(Client& client, JobId series, const OutputPaths& outputs, const InputFiles& inputs,
                 bool raw) {
  check_frame_outputs(outputs);
  Failures failures;
  int status = 0;
  for (std::uint32_t from = 0;;) {
    const std::vector<ListedFrame> frames = listed_frames(client.show_series(series, from));
    if (frames.empty()) return std::max(report_failures(failures), status);
    for (const ListedFrame& frame : frames) {
      if (frame.done()) {
        const OutputPaths numbered = outputs_of(outputs, frame.frame);
        check_not_inputs(numbered, inputs);
        status = std::max(status, fetch_and_write(client, frame.job, numbered, raw));
      } else {
        failures[frame.frame] = frame.why();
      }
    }
    from = frames.back().frame + 1;
  }
}

}  // namespace parray::commands
