// Workers that take no time: what a coordinator can take in, and how soon it answers meanwhile.
// tests/bench/coordinator runs it beside a coordinator and its jobs.
#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <cstdio>
#include <cstring>
#include <map>
#include <nlohmann/json.hpp>
#include <random>
#include <set>
#include <thread>

#include "common/base/error.h"
#include "common/process/command_line.h"
#include "common/process/run_main.h"
#include "common/trace/selfcheck/fingerprint.h"
#include "proto/clock.h"
#include "proto/keys.h"
#include "proto/messages.h"
#include "tests/bench/peer.h"
#include "tests/support/rooms.h"

namespace {

using namespace parray;

struct Arguments {
  std::string coordinator;
  int workers = 4;
  double speed = 19200;
  double seconds = 600;
  std::string keys;        ///< of a farm, directory; empty: none
  bool unwatched = false;  ///< no client asks for the list of jobs
  bool machines = false;   ///< each worker has a key of its own
};

/// Results that tracing could have given: samples of random radiance, as noisy as a picture's.
class Forger {
 public:
  msg::Result result_of(const msg::Grant& grant, double samples_per_second) {
    msg::Result result;
    result.job = grant.job;
    result.epoch = grant.epoch;
    result.seconds = static_cast<double>(grant.cells.sample_count()) / samples_per_second;
    result.isa = "none";
    const CellGrid& grid = *grant.cells.grid;
    // Packed cells stand one after the other: each kind of cell is packed once.
    std::string packed;
    for (std::uint64_t i = grant.cells.range.begin; i < grant.cells.range.end; ++i) {
      packed += cell_of(grant.cells, grid.cell(i));
    }
    result.cells = CellsPayload(Bulk::of(std::move(packed)));
    return result;
  }

 private:
  const std::string& cell_of(const CellBatch& batch, const Cell& cell) {
    std::string& packed = packed_[{cell.pixels(), cell.samples.count()}];
    if (packed.empty()) {
      GridShape shape = batch.grid->shape();
      shape.width = cell.pixels();
      shape.height = 1;
      shape.cell_pixels = cell.pixels();
      packed = pack_cells(traced(shape, cell.samples), CellGrid(shape));
    }
    return packed;
  }

  TracedCells traced(const GridShape& shape, const SampleRange& samples) {
    TracedCells traced;
    traced.range = {0, 1};
    traced.records.resize(record_bytes(shape.cell_pixels));
    const CellHeader header{std::uint64_t{samples.count()} * shape.cell_pixels, 0, 0, 0};
    std::memcpy(traced.records.data(), &header, sizeof header);
    std::uniform_real_distribution<double> radiance(0.3, 0.7);
    for (std::uint32_t x = 0; x < shape.cell_pixels; ++x) {
      PixelSums sums;
      for (std::uint32_t s = samples.begin; s < samples.end; ++s) {
        std::array<std::uint64_t, 3> fixed{};
        for (std::uint64_t& channel : fixed) {
          channel = static_cast<std::uint64_t>(radiance(random_) * 0x1p32);
        }
        sums.add(fixed, s);
      }
      std::memcpy(traced.records.data() + sizeof header + x * sizeof sums, &sums, sizeof sums);
    }
    return traced;
  }

  std::mt19937_64 random_;
  std::map<std::pair<std::uint32_t, std::uint32_t>, std::string> packed_;
};

struct FloodWorker {
  explicit FloodWorker(Peer link) : peer(std::move(link)) {}
  Peer peer;
  std::set<std::pair<std::uint64_t, std::uint64_t>> held;  ///< job, epoch
  Time heartbeat = seconds(1);                             ///< as it was told
};

/// Asks for the list of jobs every 10 ms, in a thread of its own, until none is left to be done.
class Client {
 public:
  explicit Client(const Arguments& a)
      : peer_(context_, a.coordinator, key_of(a.keys, "admin")), thread_([this] { run(); }) {}
  ~Client() {
    stop_ = true;
    thread_.join();
  }
  Client& operator=(Client&&) = delete;

  [[nodiscard]] bool done() const { return done_; }
  /// How long answers took, in milliseconds; of a client that is done.
  nlohmann::json times() {
    std::sort(answers_.begin(), answers_.end());
    const auto at = [&](double share) {
      return answers_.empty() ? 0
                              : answers_[static_cast<std::size_t>(
                                    share * static_cast<double>(answers_.size() - 1))];
    };
    return {{"answers", answers_.size()}, {"median", at(0.5)}, {"p99", at(0.99)}, {"worst", at(1)}};
  }

 private:
  void run() {
    for (std::uint64_t request = 1; !stop_ && !done_; ++request) {
      const Time asked = clock_.now();
      peer_.send(msg::ListJobs{request});
      if (answered(request)) answers_.push_back(to_seconds(clock_.now() - asked) * 1000);
      std::this_thread::sleep_for(milliseconds(10));
    }
  }

  bool answered(std::uint64_t request) {
    std::vector<zmq::pollitem_t> item{{peer_.handle(), 0, ZMQ_POLLIN, 0}};
    while (!stop_) {
      zmq::poll(item, milliseconds(100));
      while (const auto message = peer_.receive()) {
        const auto* jobs = std::get_if<msg::Jobs>(&*message);
        if (jobs != nullptr && jobs->request == request) {
          done_ = !jobs->jobs.empty() && std::all_of(jobs->jobs.begin(), jobs->jobs.end(), ended);
          return true;
        }
      }
    }
    return false;
  }

  static bool ended(const nlohmann::json& job) {
    const std::string state = job.value("state", "");
    return state == "done" || state == "failed" || state == "cancelled";
  }

  const SteadyClock clock_;
  zmq::context_t context_;
  Peer peer_;
  std::vector<double> answers_;
  std::atomic<bool> done_ = false;
  std::atomic<bool> stop_ = false;
  std::thread thread_;  // last: it uses the others
};

/// The workers, all in one thread.
class Flood {
 public:
  explicit Flood(const Arguments& a) : arguments_(a) {
    if (!a.unwatched) client_.emplace(a);
    // As if on other machines: they take no processor from the coordinator, nor from its client.
    setpriority(PRIO_PROCESS, 0, 19);
    context_.set(zmq::ctxopt::max_sockets, a.workers + 16);
    msg::Hello hello;
    hello.fingerprint = trace_fingerprint();
    for (int i = 0; i < a.workers; ++i) {
      hello.name = "flood-" + std::to_string(i);
      hello.instance = hello.name + "-" + std::to_string(getpid());
      const auto key = key_of(a.keys, a.machines ? hello.name : "worker");
      workers_.emplace_back(Peer(context_, a.coordinator, key));
      workers_.back().peer.send(hello);
    }
    for (std::size_t i = 0; i < workers_.size(); ++i) {  // spread evenly
      beats_.emplace(clock_.now() + i * seconds(1) / workers_.size(), i);
    }
  }

  /// Until no job is left that is not done.
  nlohmann::json run() {
    const Time end = clock_.now() + std::chrono::duration_cast<Time>(
                                        std::chrono::duration<double>(arguments_.seconds));
    while (clock_.now() < end && !done()) {
      serve();
      beat();
    }
    return {{"done", done()},
            {"workers", workers_.size()},
            {"leases", accepted_},
            {"answer_ms", client_ ? client_->times() : nlohmann::json()}};
  }

 private:
  [[nodiscard]] bool done() const { return client_ && client_->done(); }

  void serve() {
    std::vector<zmq::pollitem_t> items;
    items.reserve(workers_.size());
    for (FloodWorker& worker : workers_) items.push_back({worker.peer.handle(), 0, ZMQ_POLLIN, 0});
    zmq::poll(items, milliseconds(5));
    for (std::size_t i = 0; i < workers_.size(); ++i) {
      if (items[i].revents != 0) work(workers_[i]);
    }
  }

  void work(FloodWorker& worker) {
    while (const auto message = worker.peer.receive()) {
      if (const auto* grant = std::get_if<msg::Grant>(&*message)) {
        worker.held.insert({grant->job, grant->epoch});
        worker.peer.send(forger_.result_of(*grant, arguments_.speed));
      } else if (const auto* verdict = std::get_if<msg::ResultVerdict>(&*message)) {
        worker.held.erase({verdict->job, verdict->epoch});
        accepted_ += verdict->verdict == msg::Verdict::accepted ? 1 : 0;
      } else if (const auto* welcome = std::get_if<msg::Welcome>(&*message)) {
        worker.heartbeat = milliseconds(welcome->heartbeat_ms);
      } else if (const auto* refusal = std::get_if<msg::Refuse>(&*message)) {
        throw RunError("refused: " + refusal->reason);
      }
    }
  }

  void beat() {
    const Time now = clock_.now();
    while (beats_.begin()->first <= now) {
      const auto [due, index] = *beats_.begin();
      beats_.erase(beats_.begin());
      FloodWorker& worker = workers_[index];
      beats_.emplace(due + worker.heartbeat, index);
      msg::Heartbeat heartbeat;
      // The oldest wait for nothing but the commit of their results.
      constexpr std::size_t most = 64;
      const std::size_t told = std::min(most, worker.held.size());
      heartbeat.epochs.assign(std::prev(worker.held.end(), static_cast<std::ptrdiff_t>(told)),
                              worker.held.end());
      worker.peer.send(heartbeat);
    }
  }

  const Arguments& arguments_;
  const SteadyClock clock_;
  zmq::context_t context_;
  std::optional<Client> client_;
  std::vector<FloodWorker> workers_;
  Forger forger_;
  std::uint64_t accepted_ = 0;
  std::multimap<Time, std::size_t> beats_;  ///< when each worker's next is due
};

}  // namespace

int main(int argc, char** argv) {
  Arguments arguments;
  const Program program = {
      "bench_flood", "Workers that make up their results, until all jobs of a coordinator are done",
      PARRAY_VERSION};
  return run_main(program, argc, argv, [&](CommandLine& line) {
    line.option("--coordinator", arguments.coordinator, "Its address");
    line.number("--workers", arguments.workers, 1, 1 << 16, "Workers").show_default();
    line.number("--speed", arguments.speed, 1, 1e12,
                "Samples a second that each says it traces: leases last half a second at most")
        .show_default();
    line.option("--keys", arguments.keys, "Directory of the farm's keys");
    line.flag("--unwatched", arguments.unwatched,
              "Do not ask for the list of jobs; go on for --seconds");
    line.flag("--machines", arguments.machines,
              "Each worker is a machine of its own, by the key flood-0, flood-1, ...");
    line.number("--seconds", arguments.seconds, 0, 1e6, "The longest it goes on").show_default();
    return [&] {
      std::printf("%s\n", Flood(arguments).run().dump().c_str());
      return 0;
    };
  });
}
