#pragma once

#include <map>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <set>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

#include "cli/check/audit/audit.h"
#include "common/image/image.h"
#include "common/scene/settings.h"
#include "coordinator/loop/coordinator.h"
#include "tests/support/crash_store.h"
#include "tests/support/faulty_team.h"
#include "tests/support/rooms.h"
#include "tests/support/sample_scenes.h"
#include "tests/support/sim_network.h"
#include "worker/worker.h"

namespace parray::test {

/// The real coordinator and real workers on a simulated network, in virtual time, in one thread.
class SimFarm {
 public:
  /// `failing_commits`: probability that the disk is full at a commit.
  SimFarm(Faults faults, std::uint64_t seed, double failing_commits = 0,
          CoordinatorOptions options = {});

  /// Adds a worker; returns its place.
  std::size_t add_worker(double samples_per_second, Ailments ailments = {});
  /// Ends a worker without a word, as kill -9 does.
  void kill_worker(std::size_t place) { workers_[place].reset(); }
  /// A worker neither receives nor sends until `until`, as under SIGSTOP; its team goes on, so that
  /// its result is there when it continues.
  void stop_worker(std::size_t place, Time until) { workers_[place]->stopped_until = until; }
  [[nodiscard]] bool worker_is_idle(std::size_t place) const {
    return workers_[place]->team.idle();
  }
  [[nodiscard]] std::size_t worker_count() const { return workers_.size(); }
  [[nodiscard]] bool alive(std::size_t place) const { return workers_[place] != nullptr; }

  /// Ends the coordinator without a word, as kill -9 does, and starts another on what its store had
  /// committed.
  void crash_coordinator();
  [[nodiscard]] std::uint64_t crashes() const { return crashes_; }
  /// Leases whose acceptance has been sent to a worker, and that the store no longer has: must be 0
  /// at any moment.
  [[nodiscard]] std::size_t acknowledged_but_lost() const;
  [[nodiscard]] std::size_t acknowledged() const { return acknowledged_.size(); }
  /// Leases that came back in part.
  [[nodiscard]] std::size_t parts() const;
  CrashStore& store() { return store_; }

  void submit(const Scene& scene, const RenderSettings& settings);

  /// Runs until the job's picture has been fetched, or until `until`. `event` is called before
  /// every turn and may do things to the farm. False: out of time.
  template <typename Event>
  bool run(Time until, Event event) {
    while (!picture_ && network.now() < until) {
      event(*this);
      turn();
    }
    return picture_.has_value();
  }
  bool run(Time until) {
    return run(until, [](SimFarm&) {});
  }

  /// What has been fetched.
  [[nodiscard]] const nlohmann::json& report() const { return picture_->report; }
  [[nodiscard]] std::string picture_sha256() const {
    const auto parts = picture_->picture.picture(picture_->width, picture_->height);
    return image_sha256(parts->image);
  }
  /// Of its journal, as the store keeps it.
  [[nodiscard]] Audit audit();
  [[nodiscard]] const Coordinator& coordinator() const { return *coordinator_; }

  SimNetwork network;

 private:
  struct SimWorker {
    SimWorker(SimNetwork& network, const std::string& id, double speed, Ailments ailments,
              std::uint64_t seed)
        : team(network, speed, ailments, seed),
          worker(options(id), team),
          link(network.peer_end(id)) {}
    static WorkerOptions options(const std::string& id) {
      WorkerOptions options{id, id, 1, 2, "same"};
      options.host = "host";
      options.share_port = static_cast<std::uint32_t>(std::stoul(id.substr(1)));
      options.share_key = SimNetwork::share_key;
      return options;
    }

    FaultyTeam team;
    Worker worker;
    std::unique_ptr<Link> link;
    Time stopped_until{0};
  };

  void turn();
  void client_turn();
  void start_coordinator();

  void note(const Message& message);

  const CoordinatorOptions options_;
  CrashStore store_;
  std::uint64_t crashes_ = 0;
  /// Pass and cells, as an entry of the log begins.
  using Cells = std::tuple<std::uint32_t, std::uint64_t, std::uint64_t>;
  std::map<std::pair<JobId, Epoch>, Cells> granted_;
  /// What workers have returned of each lease. The holder of a copy may return more.
  std::map<std::pair<JobId, Epoch>, std::set<Cells>> returned_;
  std::set<std::pair<JobId, Epoch>> acknowledged_;
  std::unique_ptr<Coordinator> coordinator_;
  std::unique_ptr<Link> coordinator_link_;
  std::vector<std::unique_ptr<SimWorker>> workers_;
  std::uint64_t next_peer_ = 1;

  std::unique_ptr<Link> client_link_;
  std::optional<msg::Submit> request_;
  std::optional<JobId> job_;
  Time next_request_{0};
  std::optional<msg::ImageData> picture_;
};

}  // namespace parray::test
