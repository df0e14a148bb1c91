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
  /// `failing_commits` is the probability that the disk is full at a commit.
  SimFarm(Faults faults, std::uint64_t seed, double failing_commits = 0,
          CoordinatorOptions options = {});

  /// Adds a worker, and returns its number.
  std::size_t add_worker(double samples_per_second, Ailments ailments = {});
  /// Ends a worker without a message, as kill -9 does.
  void kill_worker(std::size_t place) { workers_[place].reset(); }
  /// Stops a worker until `until`, as SIGSTOP does: it receives and sends nothing. Its team
  /// continues, so its result is ready when the worker continues.
  void stop_worker(std::size_t place, Time until) { workers_[place]->stopped_until = until; }
  [[nodiscard]] bool worker_is_idle(std::size_t place) const {
    return workers_[place]->team.idle();
  }
  [[nodiscard]] std::size_t worker_count() const { return workers_.size(); }
  [[nodiscard]] bool alive(std::size_t place) const { return workers_[place] != nullptr; }

  /// Ends the coordinator without a message, as kill -9 does, and starts another with the committed
  /// state of the store.
  void crash_coordinator();
  [[nodiscard]] std::uint64_t crashes() const { return crashes_; }
  /// Returns the number of acknowledged leases that the store has lost. It must always be 0.
  [[nodiscard]] std::size_t acknowledged_but_lost() const;
  [[nodiscard]] std::size_t acknowledged() const { return acknowledged_.size(); }
  /// Returns the number of leases of which a worker returned a part.
  [[nodiscard]] std::size_t parts() const;
  CrashStore& store() { return store_; }

  void submit(const Scene& scene, const RenderSettings& settings);

  /// Runs until the job's picture has been fetched, or until `until`. Calls `event` before every
  /// turn, which may change the farm. Returns false if time is over.
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

  /// Return the fetched report and picture.
  [[nodiscard]] const nlohmann::json& report() const { return picture_->report; }
  [[nodiscard]] std::string picture_sha256() const {
    const auto parts = picture_->picture.picture(picture_->width, picture_->height);
    return image_sha256(parts->image);
  }
  /// Returns the audit of the job's journal in the store.
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
      WorkerOptions options;
      options.name = id;
      options.instance = id;
      options.fingerprint = "same";
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
  /// Pass and range of cells, the beginning of an entry of the log.
  using Cells = std::tuple<std::uint32_t, std::uint64_t, std::uint64_t>;
  std::map<std::pair<JobId, Epoch>, Cells> granted_;
  /// The cells of each lease that workers have returned. The holder of a copy may return more.
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
