// parray-worker: traces leases for a coordinator.
#include <spdlog/spdlog.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cstdlib>
#include <optional>
#include <random>

#include "common/base/cgroup_limits.h"
#include "common/base/cpu_count.h"
#include "common/base/error.h"
#include "common/log/log.h"
#include "common/process/command_line.h"
#include "common/process/run_main.h"
#include "common/process/stop_signal.h"
#include "common/trace/selfcheck/fingerprint.h"
#include "proto/zmq_link.h"
#include "worker/worker.h"

namespace {

using namespace parray::worker;

struct Arguments {
  std::string coordinator = "tcp://127.0.0.1:7400";
  int threads = usable_cpus();
  std::string keys;
  std::string name;
  double idle_exit = 0;
  std::string sharing = "on";
  LogOptions log;
};

void declare_options(CommandLine& line, Arguments& a) {
  line.section("Farm");
  line.option("--coordinator,--connect", a.coordinator,
              "Address of the coordinator, followed by those of its standbys, separated by commas")
      .type_name("ADDRESS")
      .environment("PARRAY_COORDINATOR")
      .show_default();
  line.option("--keys", a.keys,
              "File with the key of this worker, if the coordinator requires keys. In a directory, "
              "ParRay uses worker.key")
      .type_name("FILE")
      .completes(Completes::files)
      .environment("PARRAY_KEYS");
  line.number("--threads", a.threads, 1, 4096,
              "Number of threads (default: all available processors)")
      .group("Speed");
  line.option("--name", a.name,
              "Name of this worker, as the command parray workers prints it (default: host name "
              "and process id)")
      .type_name("NAME");
  line.number("--idle-exit", a.idle_exit, 0.0, 1e9,
              "Stop after so many seconds without work, connected or not; 0: never")
      .show_default();
  line.option(
          "--sharing", a.sharing,
          "on: exchange scenes with other workers, through a port that the system chooses; off: "
          "get scenes only from the coordinator")
      .one_of({"on", "off"})
      .show_default();
  a.log.add_to(line, "Lowest level of messages on stderr");
  line.example("parray-worker", "works for the coordinator of this machine with all processors");
  line.example("parray-worker --coordinator tcp://farm:7400 --keys worker.key",
               "works for the coordinator at this address");
  line.example("parray-worker --threads 8 --idle-exit 300",
               "stops after five minutes without work");
}

std::string host_name() {
  std::array<char, 100> host{};
  gethostname(host.data(), host.size() - 1);
  return host.data();
}

/// Returns the load average of the last minute; negative: not known.
double load_average() {
  double load = -1;
  return getloadavg(&load, 1) == 1 ? load : -1;
}

std::string new_instance() {
  std::random_device device;
  return std::to_string(device()) + std::to_string(device());
}

/// Logs the begin and end of connections and the scenes received. Decides when the worker stops.
class ConnectionLog {
 public:
  /// `idle_exit` is the number of seconds without work after which the worker stops; 0: never.
  ConnectionLog(const Worker& worker, spdlog::logger& log, bool keys, double idle_exit)
      : worker_(worker), log_(log), keys_(keys), idle_exit_(idle_exit) {}

  bool log_and_check_stop(const std::string& address) {
    log_scene();
    constexpr Time patience = seconds(10);
    if (!connected_ && !logged_ && clock_.now() - start_ > patience) {
      logged_ = true;
      log_.warn("no answer from {} yet: check the address, that the coordinator runs, and {}",
                address, keys_ ? "that it knows this key" : "whether it needs a key (--keys)");
    }
    if (worker_.connected() != connected_) {
      logged_ = true;
      connected_ = worker_.connected();
      connected_ ? log_.info("connected to {}", address)
                 : log_.warn("connection to {} lost: connecting again", address);
    }
    return interrupt_noted() || !worker_.refused().empty() || idle_for_too_long();
  }

 private:
  bool idle_for_too_long() {
    const Time now = clock_.now();
    if (!worker_.idle()) last_work_ = now;
    if (idle_exit_ == 0 || to_seconds(now - last_work_) < idle_exit_) return false;
    log_.info("no work for {} s: stopping because of --idle-exit", idle_exit_);
    return true;
  }

  void log_scene() {
    const SceneExchange::Tally& tally = worker_.scene_bytes();
    if (tally.scenes > logged_scenes_) {
      logged_scenes_ = tally.scenes;
      log_.info(
          "received a scene in {:.3f} s; all scenes so far: {} bytes from the coordinator, {} from "
          "workers",
          std::chrono::duration<double>(tally.took).count(), tally.from_coordinator,
          tally.from_workers);
    }
  }

  const Worker& worker_;
  spdlog::logger& log_;
  const bool keys_;
  const double idle_exit_;
  const SteadyClock clock_;
  const Time start_ = clock_.now();
  Time last_work_ = start_;  ///< last time with work
  bool connected_ = false;
  bool logged_ = false;
  std::uint64_t logged_scenes_ = 0;
};

int work(const Arguments& a) {
  const auto log = make_log("worker", a.log);
  std::optional<MemberKey> key;
  if (!a.keys.empty()) key = read_member_key(a.keys, "worker");
  const ZmqMesh mesh = open_mesh(a.coordinator, key, a.sharing == "on");
  Link& link = *mesh.link;
  const auto wake = [&link] { link.wake(); };
  ThreadTeam team(a.threads, wake);
  WorkerOptions options;
  options.host = host_name();
  options.name = a.name.empty() ? options.host + "-" + std::to_string(getpid()) : a.name;
  options.share_port = mesh.port;
  options.share_key = mesh.key;
  options.wake = wake;
  options.instance = new_instance();
  options.release = PARRAY_VERSION;
  options.processors = static_cast<std::uint32_t>(usable_cpus());
  options.memory_bytes = std::min(usable_memory(), msg::most_memory_bytes);
  options.load = load_average;
  options.recent_log = keep_lines(*log, msg::most_log_lines);
  options.threads = static_cast<std::uint32_t>(a.threads);
  options.fingerprint = trace_fingerprint();
  Worker worker(options, team);
  const SteadyClock clock;
  log->info("ParRay {} worker '{}', {} threads, for the coordinator at {}", PARRAY_VERSION,
            options.name, a.threads, a.coordinator);
  ConnectionLog connection_log(worker, *log, key.has_value(), a.idle_exit);
  run_actor(worker, link, clock,
            [&](Time) { return connection_log.log_and_check_stop(a.coordinator); });
  if (!worker.refused().empty()) {
    throw RunError("the coordinator at " + a.coordinator +
                   " refuses this worker: " + worker.refused());
  }
  worker.leave("worker stopped");
  for (Delivery& bye : worker.take_outbox()) link.send(bye.peer, std::move(bye.content));
  const SceneExchange::Tally& scenes = worker.scene_bytes();
  log->info("stopped; bytes of scenes: {} from the coordinator, {} from workers, {} handed on",
            scenes.from_coordinator, scenes.from_workers, scenes.handed_on);
  return 0;
}

}  // namespace

int main(int argc, char** argv) {
  const Program program = {"parray-worker", "Trace parts of pictures for a coordinator",
                           PARRAY_VERSION};
  Arguments arguments;
  return run_main(program, argc, argv, [&](CommandLine& line) {
    declare_options(line, arguments);
    return [&] {
      note_signals();
      return work(arguments);
    };
  });
}
