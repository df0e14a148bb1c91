// parray-worker: traces leases for a coordinator.
#include <spdlog/spdlog.h>
#include <unistd.h>

#include <array>
#include <memory>
#include <optional>
#include <random>

#include "common/base/cpu_count.h"
#include "common/base/error.h"
#include "common/log/log.h"
#include "common/process/command_line.h"
#include "common/process/run_main.h"
#include "common/process/stop_signal.h"
#include "common/trace/selfcheck/fingerprint.h"
#include "proto/zmq_link.h"
#include "proto/zmq_mesh.h"
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
  line.option("--coordinator,--connect", a.coordinator,
              "The coordinator's address, and its standbys', with commas between")
      .type_name("ADDRESS")
      .environment("PARRAY_COORDINATOR")
      .show_default()
      .group("Farm");
  line.option("--keys", a.keys, "Key of this worker, of a coordinator that wants one: worker.key")
      .type_name("FILE")
      .completes(Completes::files)
      .environment("PARRAY_KEYS")
      .group("Farm");
  line.number("--threads", a.threads, 1, 4096,
              "Threads to trace with (default: every processor that may be used)")
      .group("Speed");
  line.option("--name", a.name, "Name shown by parray workers (default: host name and process)")
      .type_name("NAME")
      .group("Farm");
  line.number("--idle-exit", a.idle_exit, 0.0, 1e9,
              "End after so many seconds without work, connected or not; 0: never")
      .show_default()
      .group("Farm");
  line.option("--sharing", a.sharing,
              "on: hand scenes on to other workers, by a free port, and take them from there; off: "
              "from the coordinator alone")
      .one_of({"on", "off"})
      .show_default()
      .group("Farm");
  a.log.add_to(line, "What is told on stderr: this, and worse");
  line.example("parray-worker", "with all processors, for the coordinator of this machine");
  line.example("parray-worker --coordinator tcp://farm:7400 --keys worker.key",
               "for another machine's");
  line.example("parray-worker --threads 8 --idle-exit 300",
               "leaves after five minutes without work");
}

std::string host_name() {
  std::array<char, 100> host{};
  gethostname(host.data(), host.size() - 1);
  return host.data();
}

std::string fresh_instance() {
  std::random_device device;
  return std::to_string(device()) + std::to_string(device());
}

/// Logs connections that begin and end, by watching the worker's state.
class Reporter {
 public:
  /// `idle_exit` is the number of seconds without work after which the worker stops; 0: never.
  Reporter(const Worker& worker, spdlog::logger& log, bool keys, double idle_exit)
      : worker_(worker), log_(log), keys_(keys), idle_exit_(idle_exit) {}

  bool stop(const std::string& address) {
    tell_scene();
    constexpr Time long_since = seconds(10);
    if (!connected_ && !told_ && clock_.now() - began_ > long_since) {
      told_ = true;
      log_.warn("no word from {} yet: is it running{}?", address,
                keys_ ? ", and does it know this key" : ", or does it want a key (--keys)");
    }
    if (worker_.connected() != connected_) {
      told_ = true;
      connected_ = worker_.connected();
      connected_ ? log_.info("serving {}", address)
                 : log_.warn("no word from {}: trying again", address);
    }
    return interrupt_noted() || !worker_.refused().empty() || idle_for_too_long();
  }

 private:
  bool idle_for_too_long() {
    const Time now = clock_.now();
    if (!worker_.idle()) {
      at_work_ = now;
    }
    if (idle_exit_ == 0 || to_seconds(now - at_work_) < idle_exit_) {
      return false;
    }
    log_.info("no work for {} s: leaving, as --idle-exit says", idle_exit_);
    return true;
  }

  void tell_scene() {
    const SceneExchange::Tally& tally = worker_.scene_bytes();
    if (tally.scenes > told_scenes_) {
      told_scenes_ = tally.scenes;
      log_.info(
          "a scene has come in {:.3f} s; all scenes so far: {} bytes from the coordinator, {} from "
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
  const Time began_ = clock_.now();
  Time at_work_ = began_;  ///< last time with work
  bool connected_ = false;
  bool told_ = false;
  std::uint64_t told_scenes_ = 0;
};

int work(const Arguments& a) {
  const auto log = make_log("worker", a.log);
  std::optional<MemberKey> key;
  if (!a.keys.empty()) {
    key = read_member_key(a.keys, "worker");
  }
  ZmqMesh link({a.coordinator, default_max_message_bytes, seconds(1), key, a.sharing == "on"});
  const auto wake = [&link] { link.wake(); };
  ThreadTeam team(a.threads, wake);
  WorkerOptions options;
  options.host = host_name();
  options.name = a.name.empty() ? options.host + "-" + std::to_string(getpid()) : a.name;
  options.share_port = link.port();
  options.share_key = link.key();
  options.wake = wake;
  options.instance = fresh_instance();
  options.threads = static_cast<std::uint32_t>(a.threads);
  options.fingerprint = trace_fingerprint();
  Worker worker(options, team);
  const SteadyClock clock;
  log->info("ParRay {} worker '{}', {} threads, for {}", PARRAY_VERSION, options.name, a.threads,
            a.coordinator);
  Reporter reporter(worker, *log, key.has_value(), a.idle_exit);
  run_actor(worker, link, clock, [&](Time) { return reporter.stop(a.coordinator); });
  if (!worker.refused().empty()) {
    throw RunError("the coordinator at " + a.coordinator +
                   " refuses this worker: " + worker.refused());
  }
  worker.leave("worker stopped");
  for (Delivery& goodbye : worker.take_outbox()) {
    link.send(goodbye.peer, std::move(goodbye.content));
  }
  const SceneExchange::Tally& scenes = worker.scene_bytes();
  log->info("stopped; bytes of scenes: {} from the coordinator, {} from workers, {} handed on",
            scenes.from_coordinator, scenes.from_workers, scenes.handed_on);
  return 0;
}

}  // namespace

int main(int argc, char** argv) {
  const Program program = {"parray-worker",
                           "Trace what a coordinator leases, with all processors of this machine",
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
