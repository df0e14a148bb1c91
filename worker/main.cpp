// parray-worker: traces leases for a coordinator.
#include <spdlog/sinks/stdout_color_sinks.h>
#include <spdlog/spdlog.h>
#include <unistd.h>

#include <array>
#include <memory>
#include <random>

#include "common/base/cpu_count.h"
#include "common/base/error.h"
#include "common/trace/fingerprint.h"
#include "proto/daemon_main.h"
#include "proto/zmq_link.h"
#include "worker/worker.h"

namespace {

using namespace parray;

struct Arguments {
  std::string connect = "tcp://127.0.0.1:7400";
  int threads = usable_cpus();
  std::string name;
  std::string log_level = "info";
};

void declare_options(CLI::App& app, Arguments& a) {
  app.set_version_flag("--version", PARRAY_VERSION);
  app.add_option("--connect", a.connect, "The coordinator's address")
      ->envname("PARRAY_COORDINATOR")
      ->capture_default_str();
  app.add_option("--threads", a.threads, "Threads that trace; default: the usable CPUs")
      ->check(CLI::Range(1, 4096))
      ->capture_default_str();
  app.add_option("--name", a.name, "Name shown by parray workers; default: host name and process");
  app.add_option("--log-level", a.log_level, "debug, info, warn or error")
      ->check(CLI::IsMember({"debug", "info", "warn", "error"}))
      ->capture_default_str();
}

std::string default_name() {
  std::array<char, 100> host{};
  gethostname(host.data(), host.size() - 1);
  return std::string(host.data()) + "-" + std::to_string(getpid());
}

std::string fresh_instance() {
  std::random_device device;
  return std::to_string(device()) + std::to_string(device());
}

/// Tells connections made and lost, by watching the worker's state.
class Reporter {
 public:
  Reporter(const Worker& worker, spdlog::logger& log) : worker_(worker), log_(log) {}

  bool stop(const std::string& address) {
    if (worker_.connected() != connected_) {
      connected_ = worker_.connected();
      connected_ ? log_.info("serving {}", address)
                 : log_.warn("no word from {}: trying again", address);
    }
    return stop_requested() || !worker_.refused().empty();
  }

 private:
  const Worker& worker_;
  spdlog::logger& log_;
  bool connected_ = false;
};

int work(const Arguments& a) {
  const auto log = spdlog::stderr_color_mt("worker");
  log->set_level(spdlog::level::from_str(a.log_level));
  const auto link = zmq_connect(a.connect, default_max_message_bytes, seconds(1));
  ThreadTeam team(a.threads, [&link] { link->wake(); });
  WorkerOptions options;
  options.name = a.name.empty() ? default_name() : a.name;
  options.instance = fresh_instance();
  options.threads = static_cast<std::uint32_t>(a.threads);
  options.fingerprint = trace_fingerprint();
  Worker worker(options, team);
  const SteadyClock clock;
  log->info("ParRay {} worker '{}', {} threads, for {}", PARRAY_VERSION, options.name, a.threads,
            a.connect);
  Reporter reporter(worker, *log);
  run_actor(worker, *link, clock, [&](Time) { return reporter.stop(a.connect); });
  if (!worker.refused().empty()) {
    throw RunError("the coordinator at " + a.connect + " refuses this worker: " + worker.refused());
  }
  worker.leave("worker stopped");
  for (Delivery& goodbye : worker.take_outbox()) {
    link->send(goodbye.peer, std::move(goodbye.frames));
  }
  log->info("stopped");
  return 0;
}

}  // namespace

int main(int argc, char** argv) {
  try {
    CLI::App app("Traces leases for a ParRay coordinator.", "parray-worker");
    Arguments arguments;
    declare_options(app, arguments);
    return parray::daemon_main(app, argc, argv, [&] { return work(arguments); });
  } catch (...) {  // not even the options could be made
    return 1;
  }
}
