#pragma once

#include <doctest/doctest.h>
#include <spdlog/logger.h>
#include <spdlog/sinks/ostream_sink.h>

#include <atomic>
#include <functional>
#include <map>
#include <memory>
#include <nlohmann/json.hpp>
#include <sstream>
#include <string>
#include <utility>
#include <vector>

#include "cli/check/audit/audit.h"
#include "common/scene/settings.h"
#include "coordinator/loop/coordinator.h"
#include "tests/support/faulty_team.h"
#include "tests/support/rooms.h"
#include "tests/support/sample_scenes.h"
#include "tests/support/sim_referee.h"
#include "tests/support/timed_cells.h"
#include "worker/cell_tracer.h"

namespace parray::test {

inline CoordinatorOptions service_options() {
  CoordinatorOptions options;
  options.fingerprint = "same";
  options.job_thread.threaded = false;
  options.random = [dice = std::make_shared<Dice>(1)] { return dice->unit(); };
  options.referee = std::make_shared<SimReferee>();
  return options;
}

/// Options with which another machine checks all leases.
inline CoordinatorOptions checking_all() {
  CoordinatorOptions options = service_options();
  options.checks.share = 0.5;
  options.random = [] { return 0.2; };
  return options;
}

/// A coordinator in virtual time. The test plays its peers. Every message is encoded, and none is
/// lost.
class Service {
 public:
  explicit Service(CoordinatorOptions options = service_options(), Store* store = nullptr)
      : options_(std::move(options)), store_(store) {
    restart();
  }

  /// Starts another coordinator with the same store, without telling the peers.
  void restart() { restart(store_); }
  /// Does the same with another store.
  void restart(Store* store) {
    store_ = store;
    coordinator_.reset();
    inbox_.clear();
    coordinator_ = std::make_unique<Coordinator>(options_, store_, log_);
    options_.first_epoch += Epoch{1} << 32;
  }

  void say(const PeerId& peer, const Message& message, const Sender& sender = {}) {
    say_frames(peer, encode(message), sender);
  }
  void say_frames(const PeerId& peer, Frames frames, const Sender& sender = {}) {
    coordinator_->receive(now_, {peer, std::move(frames), sender});
  }
  void turn(Time by = milliseconds(10), bool drained = true) {
    now_ += by;
    coordinator_->tick(now_, drained);
    for (Delivery& delivery : coordinator_->take_outbox()) {
      inbox_[delivery.peer].push_back(decode(delivery.content.frames()));
    }
  }

  /// Removes all messages of type M from a peer's inbox, and returns them.
  template <typename M>
  std::vector<M> heard(const PeerId& peer) {
    std::vector<M> found;
    auto& inbox = inbox_[peer];
    for (Message& message : inbox) {
      if (auto* m = std::get_if<M>(&message)) found.push_back(std::move(*m));
    }
    std::erase_if(inbox, [](const Message& m) { return std::holds_alternative<M>(m); });
    return found;
  }
  /// Returns the answer to a client's request.
  template <typename M>
  M ask(const Message& request) {
    say("client", request);
    turn(Time(0));
    auto answers = heard<M>("client");
    return answers.empty() ? M{} : std::move(answers.back());
  }

  JobId submit(const Scene& scene, const RenderSettings& settings, std::uint32_t priority = 50,
               const std::string& user = {}) {
    msg::Submit submit = submission(scene, settings, priority);
    submit.user = user;
    return ask<msg::Submitted>(submit).job;
  }
  nlohmann::json steer(JobId job, msg::JobAction action, std::uint32_t priority = 50) {
    return ask<msg::Job>(msg::SteerJob{1, job, action, priority}).job;
  }
  /// Returns the reason why a request is refused; empty: it is not refused.
  std::string refusal(const Message& request) { return ask<msg::Error>(request).message; }
  msg::Submit submission(const Scene& scene, const RenderSettings& settings,
                         std::uint32_t priority = 50) {
    msg::Submit submit;
    submit.token = "token " + std::to_string(next_token_++);
    submit.name = "scene";
    submit.priority = priority;
    submit.settings = settings;
    submit.scene = ScenePayload(std::make_shared<const Scene>(scene));
    return submit;
  }
  nlohmann::json job(JobId id) { return ask<msg::Job>(msg::ShowJob{1, id}).job; }
  std::string state(JobId id) { return job(id).at("state"); }
  nlohmann::json worker(const std::string& name) {
    for (const auto& worker : ask<msg::Workers>(msg::ListWorkers{1}).workers) {
      if (worker.at("name") == name) return worker;
    }
    return {};
  }
  /// Fetches the picture of a job that is done.
  msg::ImageData fetch(JobId id) { return ask<msg::ImageData>(msg::Fetch{1, id, false, false}); }
  std::string sha256(JobId id) {
    const auto image = fetch(id);
    return image.width == 0 ? "no picture"
                            : image_sha256(image.picture.picture(image.width, image.height)->image);
  }

  [[nodiscard]] Time now() const { return now_; }
  [[nodiscard]] const Coordinator::Tally& tally() const { return coordinator_->tally(); }
  Coordinator& coordinator() { return *coordinator_; }
  /// Returns the coordinator's log.
  [[nodiscard]] std::string log() const { return lines_->str(); }

 private:
  std::shared_ptr<std::ostringstream> lines_ = std::make_shared<std::ostringstream>();
  std::shared_ptr<spdlog::logger> log_ = std::make_shared<spdlog::logger>(
      "log", std::make_shared<spdlog::sinks::ostream_sink_st>(*lines_));
  CoordinatorOptions options_;
  Store* store_;
  std::unique_ptr<Coordinator> coordinator_;
  std::map<PeerId, std::vector<Message>> inbox_;
  Time now_ = seconds(1000);
  int next_token_ = 1;
};

/// A worker that the test plays: the test decides what it returns for a lease.
class Hand {
 public:
  /// `sender` is how the coordinator sees the worker, by default as a separate machine.
  Hand(Service& service, std::string name, std::uint32_t capacity = 1, std::string host = "here",
       Sender sender = {})
      : service_(service),
        name_(std::move(name)),
        host_(std::move(host)),
        capacity_(capacity),
        sender_(std::move(sender)) {
    join();
  }
  /// Makes a worker at this address.
  Hand(Service& service, std::string name, const std::string& address)
      : Hand(service, std::move(name), 1, "here", {Role::any, "", 1, address}) {}

  /// Joins as a process that has just started.
  void join() {
    ++instance_;
    peer_ = name_ + " " + std::to_string(instance_);
    held.clear();
    say_hello();
  }
  /// Joins as a process that was cut off for a while.
  void come_back() {
    held.clear();
    say_hello();
  }
  /// Joins as a process that has just started under another name.
  void join_as(std::string name) {
    name_ = std::move(name);
    join();
  }
  void say(const Message& message) { service_.say(peer_, message, sender_); }

  /// Reads the messages that have arrived: grants, revoked leases and verdicts.
  void listen() {
    for (auto& grant : service_.heard<msg::Grant>(peer_)) {
      held[{grant.job, grant.epoch}] = std::move(grant);
    }
    for (const auto& revoke : service_.heard<msg::Revoke>(peer_)) {
      held.erase({revoke.job, revoke.epoch});
    }
    for (const auto& verdict : service_.heard<msg::ResultVerdict>(peer_)) {
      verdicts.push_back(verdict.verdict);
    }
  }
  /// Sends a heartbeat. It says that the worker traces the lease with the lowest epoch and makes
  /// progress.
  void beat() {
    msg::Heartbeat heartbeat;
    heartbeat.traced = ++beats_;
    for (const auto& [key, grant] : held) heartbeat.epochs.push_back(key);
    say(heartbeat);
  }
  /// Removes the first lease that the worker holds, and returns it.
  msg::Grant put_down() {
    msg::Grant grant = held.begin()->second;
    held.erase(held.begin());
    return grant;
  }

  static TracedCells trace(const Scene& scene, const msg::Grant& grant) {
    std::atomic<std::uint64_t> count = 0;
    return trace_cells(*make_path_tracer(scene, grant.settings), grant.cells, 1, count, false);
  }
  static msg::Result result(const msg::Grant& grant, TracedCells cells) {
    msg::Result result;
    result.job = grant.job;
    result.epoch = grant.epoch;
    result.seconds = 0.01;
    result.isa = "scalar";
    result.grid = grant.cells.grid;
    result.cells = CellsPayload(std::make_shared<const TracedCells>(std::move(cells)));
    return result;
  }
  void send_honest(const msg::Grant& grant) { say(result(grant, trace(small_scene(), grant))); }
  void send_wrong(const msg::Grant& grant) {
    TracedCells cells = trace(small_scene(), grant);
    falsify(cells, record_bytes(grant.cells.grid->shape().cell_pixels));
    say(result(grant, std::move(cells)));
  }
  /// Sends possible samples of another picture, which differ visibly.
  void send_other_picture(const msg::Grant& grant) {
    send_part(grant, grant.cells.range.count(), true);
  }
  /// Sends sums that are impossible for samples.
  void send_forgery(const msg::Grant& grant) {
    TracedCells cells = trace(small_scene(), grant);
    cells.records[sizeof(CellHeader) + 7] = std::byte{0x80};  // 2^63
    say(result(grant, std::move(cells)));
  }
  /// Sends only the lease's first cells.
  void send_part(const msg::Grant& grant, std::uint64_t cells, bool lie = false) {
    msg::Grant part = grant;
    part.cells = first_cells(grant.cells, cells);
    part.settings->seed += lie ? 1 : 0;
    msg::Result returned = result(grant, trace(small_scene(), part));
    returned.count = cells;
    say(returned);
  }
  void send_failure(const msg::Grant& grant) {
    say(msg::Failed{grant.job, grant.epoch, "not enough memory"});
  }

  [[nodiscard]] const std::string& name() const { return name_; }
  [[nodiscard]] const PeerId& peer() const { return peer_; }

  std::map<std::pair<JobId, Epoch>, msg::Grant> held;
  std::vector<msg::Verdict> verdicts;

 private:
  void say_hello() {
    say(msg::Hello{protocol_version, name_, std::to_string(instance_), 1, capacity_, trace_version,
                   "same", host_});
    service_.turn(Time(0));
  }

  Service& service_;
  std::string name_;
  std::string host_;
  std::uint32_t capacity_;
  Sender sender_;
  PeerId peer_;
  int instance_ = 0;
  std::uint64_t beats_ = 0;
};

/// What a worker returns for a lease.
using Manner = std::function<void(Hand& hand, const msg::Grant& grant)>;
using Hands = std::vector<std::pair<Hand*, Manner>>;
inline void honest(Hand& hand, const msg::Grant& grant) { hand.send_honest(grant); }
inline void lying(Hand& hand, const msg::Grant& grant) { hand.send_wrong(grant); }
inline void lying_loudly(Hand& hand, const msg::Grant& grant) { hand.send_other_picture(grant); }
/// Returns the first cells of a lease, a random number of them if the lease allows it. One of
/// `lies` results is wrong; 0: none.
inline Manner in_parts(std::uint64_t seed, std::uint64_t lies = 0) {
  return [lies, dice = std::make_shared<Dice>(seed)](Hand& hand, const msg::Grant& grant) {
    const std::uint64_t all = grant.cells.range.count();
    const bool lie = lies > 0 && dice->one_in(lies);
    hand.send_part(grant, grant.longest > 0 ? 1 + dice->below(all) : all, lie);
  };
}
inline void failing(Hand& hand, const msg::Grant& grant) { hand.send_failure(grant); }
inline void idle(Hand& /*hand*/, const msg::Grant& /*grant*/) {}

/// Lets each worker return one lease per round of `pace`, in its own manner, until the job has
/// ended or `most_rounds` are over. Returns the number of rounds.
inline int work(Service& service, const Hands& hands, JobId job, int most_rounds = 500,
                Time pace = milliseconds(10)) {
  for (int round = 0; round < most_rounds; ++round) {
    service.turn(pace);
    for (const auto& [hand, manner] : hands) {
      hand->listen();
      hand->beat();
      if (!hand->held.empty()) manner(*hand, hand->put_down());
    }
    service.turn(Time(0));
    const std::string state = service.state(job);
    if (state == "done" || state == "failed" || state == "cancelled") return round;
  }
  return most_rounds;
}

/// Returns settings of a picture with many leases.
inline RenderSettings many_leases() {
  RenderSettings settings = small_settings(small_scene());
  settings.height = 48;
  settings.samples_per_pixel = 4;
  settings.schedule = SchedulePolicy::factoring;
  return settings;
}

/// Returns the same in passes. Each pass decides the samples of the next.
inline RenderSettings in_passes() {
  RenderSettings settings = many_leases();
  const std::uint64_t pixels = std::uint64_t{settings.width} * settings.height;
  settings.adaptive = true;
  settings.passes = {4 * pixels, 3 * pixels, 2 * pixels};
  return settings;
}

/// Returns settings of a picture whose cells are layers of samples.
inline RenderSettings in_layers() {
  RenderSettings settings = many_leases();
  settings.height = 3;
  settings.samples_per_pixel = 1000;
  return settings;
}

/// Returns the hash of the picture of small_scene() that one thread traces.
inline std::string expected_sha256(const RenderSettings& settings) {
  return settings.in_passes() ? reference_passes_sha256(small_scene(), settings)
                              : reference_sha256(small_scene(), settings);
}

/// Returns the audit of the job's journal.
inline Audit audit_of(Service& service, JobId job) {
  const auto data = service.ask<msg::JournalData>(msg::FetchJournal{1, job});
  return audit_journal(read_journal(data.journal.data.view()));
}

/// Checks that a job is done, that its picture is right, and that every cell counts once. Returns
/// the audit.
inline Audit check_right(Service& service, JobId job, const RenderSettings& settings) {
  REQUIRE(service.state(job) == "done");
  CHECK(service.sha256(job) == expected_sha256(settings));
  if (settings.in_passes()) CHECK(service.fetch(job).report.at("passes") == settings.passes);
  Audit audit = audit_of(service, job);
  CHECK(audit.complete());
  return audit;
}

}  // namespace parray::test
