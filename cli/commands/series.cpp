#include "cli/commands/series.h"

#include <unistd.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <iostream>
#include <iterator>
#include <map>
#include <set>
#include <span>
#include <utility>

#include "cli/commands/prepare.h"
#include "cli/commands/rendering.h"
#include "cli/input/formats/format_table.h"
#include "cli/input/scene_file/camera_path.h"
#include "cli/output/progress.h"
#include "common/base/error.h"
#include "common/base/files.h"
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

std::vector<ListedFrame> listed_frames(const json& map) {
  if (!map.contains("frame_list")) {
    throw InputError("job " + map.value("id", json()).dump() +
                     " is not a series of frames: use the name of one picture, without #");
  }
  std::vector<ListedFrame> frames;
  try {
    for (const json& entry : map.at("frame_list")) {
      frames.push_back({entry.at("frame"), entry.at("job"),
                        printable(entry.at("state").get<std::string>()),
                        printable(entry.at("reason").get<std::string>(), 500)});
    }
  } catch (const json::exception& error) {
    throw RunError(std::string("reading the coordinator's answer: ") + error.what());
  }
  return frames;
}

OutputPaths outputs_of(const OutputPaths& outputs, std::uint32_t frame) {
  OutputPaths numbered = outputs;
  numbered.image = with_frame_number(outputs.image.string(), frame);
  numbered.report = with_frame_number(outputs.report.string(), frame);
  numbered.error_map = with_frame_number(outputs.error_map.string(), frame);
  return numbered;
}

/// Fetches and writes one frame. Returns the exit status. Throws InputError or RunError.
int deliver_frame(Client& client, const ListedFrame& frame, const OutputPaths& outputs,
                  bool raw = false) {
  return fetch_and_write(client, frame.job, outputs_of(outputs, frame.frame), raw);
}

/// Frames without a picture, and the reasons.
using Failures = std::map<std::uint32_t, std::string>;

int report_failures(const Failures& failures) {
  for (const auto& [frame, why] : failures) {
    std::cerr << "parray: frame " << frame << ": " << why << "\n";
  }
  return failures.empty() ? 0 : 1;
}

/// Returns a token of the request. An equal request has the same token and so finds the frames that
/// were submitted before. Numbered scenes contribute their names, other files their contents.
std::string token_of(const SeriesRequest& request) {
  const FrameRange& frames = request.frames;
  const std::string text =
      std::to_string(getuid()) + "\n" +
      std::filesystem::absolute(request.scene).lexically_normal().string() + "\n" +
      std::to_string(frames.first) + "-" + std::to_string(frames.last) + ":" +
      std::to_string(frames.step) + "\n" + request.render.as_given() +
      (has_frame_number(request.scene) ? "" : read_file(request.scene).value_or("")) + "\n" +
      (request.camera_path.empty() ? "" : read_file(request.camera_path).value_or(""));
  constexpr std::size_t digits = 48;
  return sha256_hex(std::as_bytes(std::span(text))).substr(0, digits);
}

/// Submits the frames of a request, and follows them until they end.
class SeriesRun {
 public:
  SeriesRun(Client& client, const SeriesRequest& request)
      : client_(client),
        request_(request),
        token_(token_of(request)),
        progress_(
            progress_style(request.following.quiet || !request.wait, request.following.progress),
            std::cerr, terminal_columns) {
    if (!request.camera_path.empty()) path_.emplace(request.camera_path);
  }

  int run() {
    find_earlier_frames();
    for (std::uint32_t place = 0; place < request_.frames.count(); ++place) {
      const std::uint32_t frame = request_.frames.number(place);
      if (known_.contains(frame)) continue;
      if (auto submission = load(frame)) submit(std::move(*submission));
      update_if_due();
      check_not_cancelled();
    }
    settle(0);
    while (request_.wait && !pending_.empty()) {
      update();
      client_.rest(polling_interval(clock_.now() - begin_));
    }
    progress_.make_way();
    if (request_.wait && series_ != 0) run_end();
    return std::max(report_failures(failures_), status_);
  }

  [[nodiscard]] JobId series() const { return series_; }

 private:
  /// Finds the frames that an earlier run submitted.
  void find_earlier_frames() {
    for (const json& map : client_.jobs()) {
      if (map.value("frames", 0) > 0 && map.value("series", "") == token_) set_series(map.at("id"));
    }
    for (std::uint32_t from = 0; series_ != 0;) {
      const auto frames = listed_frames(client_.show_series(series_, from));
      if (frames.empty()) break;
      for (const ListedFrame& frame : frames) {
        known_.insert(frame.frame);
        pending_.insert(frame.frame);
      }
      from = frames.back().frame + 1;
    }
    if (!known_.empty()) {
      std::cerr << "parray: series " << series_ << " continues: " << known_.size() << " of "
                << request_.frames.count() << " frames were submitted before\n";
    }
  }

  void set_series(JobId series) {
    series_ = series;
    std::cout << series << std::endl;
  }

  FrameChange change_of(std::uint32_t frame) const {
    FrameChange change;
    if (path_) {
      change.camera = path_->at(frame);
    } else if (!has_frame_number(request_.scene)) {
      change.particles = frame;
    }
    return change;
  }

  /// Loads a frame. Returns nothing if it cannot be submitted; failures_ then has the reason.
  std::optional<Submission> load(std::uint32_t frame) {
    try {
      Submission submission =
          load_submission(RenderMode::series, with_frame_number(request_.scene, frame),
                          request_.render, request_.priority, change_of(frame))
              .submission;
      submission.max_failures = request_.max_failures;
      if (!request_.name.empty()) submission.name = request_.name;
      submission.series = token_;
      submission.frame = frame;
      submission.frames = request_.frames.count();
      return submission;
    } catch (const InputError& error) {
      failures_[frame] = error.what();
      return {};
    }
  }

  /// Submits a frame. The first frame is submitted alone, because its answer has the number of the
  /// series. Later ones are submitted several at a time.
  void submit(Submission submission) {
    settle(series_ == 0 ? 0 : most_in_flight - 1);
    client_.start_submit(std::move(submission));
    if (series_ == 0) settle(0);
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

  /// Handles the coordinator's answer to a submission.
  void handle(Client::Outcome outcome) {
    const std::uint32_t frame = outcome.submission.frame;
    try {
      if (outcome.refusal) std::rethrow_exception(outcome.refusal);
      if (series_ == 0) set_series(client_.show(outcome.job).at("series"));
      pending_.insert(frame);
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
    if (series_ == 0) return;
    const json map = client_.show_series(series_, pending_.empty() ? 0 : *pending_.begin());
    const JobStatus status = job_status(map);
    progress_.show(clock_.now(), status);
    for (const ListedFrame& frame : listed_frames(map)) {
      if (frame.ended() && pending_.erase(frame.frame) > 0) handle_ended(frame);
    }
    cancelled_ = status.state == name_of(JobState::cancelled);
  }

  void run_end() const {
    const bool done = failures_.empty();
    run_end_command(request_.following.on_end, series_,
                    std::string(name_of(done ? JobState::done : JobState::failed)),
                    done ? "" : failures_.begin()->second, request_.outputs.image.string());
  }

  /// Throws RunError if the series was cancelled before all frames were submitted.
  void check_not_cancelled() const {
    if (cancelled_) {
      const std::string number = std::to_string(series_);
      throw RunError("series " + number + " was cancelled: use parray requeue " + number +
                     " to continue, or parray forget " + number + " to start again");
    }
  }

  /// Fetches and writes a frame that is done, or notes why it failed.
  void handle_ended(const ListedFrame& frame) {
    if (!frame.done()) {
      failures_[frame.frame] = frame.why();
    } else if (request_.wait && !request_.outputs.none()) {
      progress_.make_way();
      try {
        status_ = std::max(status_, deliver_frame(client_, frame, request_.outputs));
      } catch (const InputError& error) {
        failures_[frame.frame] = error.what();
      } catch (const RunError& error) {
        failures_[frame.frame] = error.what();
      }
    }
  }

  /// Largest number of submissions without an answer: enough to share the coordinator's commits.
  static constexpr std::size_t most_in_flight = 64;
  /// Largest size of their scenes together. A larger scene is submitted alone.
  static constexpr std::uint64_t most_bytes_in_flight = std::uint64_t{1} << 25;

  Client& client_;
  const SeriesRequest& request_;
  const std::string token_;
  std::optional<CameraPath> path_;
  Progress progress_;
  SteadyClock clock_;
  Time begin_ = clock_.now();
  Time next_update_{};
  JobId series_ = 0;
  std::set<std::uint32_t> known_;                ///< submitted by an earlier run
  std::set<std::uint32_t> pending_;              ///< submitted, and not known to have ended
  std::map<std::uint32_t, Submission> refused_;  ///< the coordinator had no room for these frames
  std::string waits_for_;                        ///< the last reason that was printed
  Failures failures_;
  bool cancelled_ = false;
  int status_ = 0;
};

}  // namespace

void check_frame_outputs(const OutputPaths& outputs) {
  for (const auto& file : {outputs.image, outputs.report, outputs.error_map}) {
    if (!file.empty() && !has_frame_number(file.string())) {
      throw InputError(printable(file.string(), 4096) +
                       ": every frame needs its own file: write #### for the frame's number");
    }
  }
  check_outputs(outputs_of(outputs, 0));
}

/// Throws InputError if the scene is a file of particles, whose automatic camera would differ from
/// frame to frame.
static void check_scene(const SeriesRequest& request) {
  if (has_frame_number(request.scene) || !request.camera_path.empty()) return;
  PackedFile file(request.scene);
  if (particle_format_of(file) != nullptr) {
    throw InputError(printable(request.scene, 4096) +
                     ": the automatic camera of a particle file differs from frame to frame: write "
                     "a scene file, which has one camera, with parray convert, and submit that");
  }
}

int submit_series(Client& client, const SeriesRequest& request) {
  check_scene(request);
  const DeferredInterrupts deferred;
  SeriesRun run(client, request);
  try {
    return run.run();
  } catch (const Interrupted&) {
    throw Interrupted(
        "interrupted; the same command continues" +
        (run.series() == 0 ? std::string() : ", or parray cancel " + std::to_string(run.series())));
  }
}

int fetch_series(Client& client, JobId series, const OutputPaths& outputs, bool raw) {
  check_frame_outputs(outputs);
  Failures failures;
  int status = 0;
  for (std::uint32_t from = 0;;) {
    const std::vector<ListedFrame> frames = listed_frames(client.show_series(series, from));
    if (frames.empty()) return std::max(report_failures(failures), status);
    for (const ListedFrame& frame : frames) {
      if (frame.done()) {
        status = std::max(status, deliver_frame(client, frame, outputs, raw));
      } else {
        failures[frame.frame] = frame.why();
      }
    }
    from = frames.back().frame + 1;
  }
}

}  // namespace parray::commands
