// parray-coordinator: the service that owns jobs, pictures and leases.
#include <spdlog/sinks/stdout_color_sinks.h>
#include <spdlog/spdlog.h>

#include <iostream>
#include <memory>

#include "common/base/error.h"
#include "common/trace/fingerprint.h"
#include "coordinator/coordinator.h"
#include "coordinator/sqlite_store.h"
#include "proto/daemon_main.h"
#include "proto/zmq_link.h"

namespace {

using namespace parray;

struct Arguments {
  std::string bind = "tcp://127.0.0.1:7400";
  std::size_t max_message_bytes = default_max_message_bytes;
  std::string state;
  double lease_timeout = 10;
  double heartbeat = 1;
  std::string log_level = "info";
  CoordinatorOptions options;
};

void declare_options(CLI::App& app, Arguments& a) {
  app.set_version_flag("--version", PARRAY_VERSION);
  app.add_option("--bind", a.bind, "Address to serve: tcp://ADDRESS:PORT (port * for a free one)")
      ->capture_default_str();
  app.add_option("--state", a.state,
                 "Directory for jobs, accepted rows and pictures, so that a coordinator started "
                 "again goes on; without it they end with the process");
  app.add_option("--max-jobs", a.options.max_jobs,
                 "Jobs kept; the oldest that has ended makes room")
      ->check(CLI::Range(1, 1000000))
      ->capture_default_str();
  app.add_option("--max-workers", a.options.max_workers, "Workers served at once")
      ->check(CLI::Range(1, 1000000))
      ->capture_default_str();
  app.add_option("--max-message-bytes", a.max_message_bytes,
                 "Largest message taken; a scene or picture beyond it is refused")
      ->check(CLI::Range(std::size_t{1} << 20, std::size_t{1} << 40))
      ->capture_default_str();
  app.add_option("--heartbeat", a.heartbeat,
                 "Seconds between a worker's signs of life; five times that without one and it is "
                 "lost")
      ->check(CLI::Range(0.05, 60.0))
      ->capture_default_str();
  app.add_option("--lease-timeout", a.lease_timeout,
                 "Seconds without progress after which a lease goes to another worker")
      ->check(CLI::Range(0.1, 3600.0))
      ->capture_default_str();
  app.add_option("--log-level", a.log_level, "debug (every lease), info, warn or error")
      ->check(CLI::IsMember({"debug", "info", "warn", "error"}))
      ->capture_default_str();
}

Time from_seconds(double value) {
  return std::chrono::duration_cast<Time>(std::chrono::duration<double>(value));
}

std::unique_ptr<Store> open_store(const std::string& directory) {
  if (directory.empty()) {
    return std::make_unique<MemoryStore>();
  }
  return std::make_unique<SqliteStore>(directory);
}

int serve(Arguments& a) {
  if (!is_loopback(a.bind)) {
    throw InputError("--bind " + a.bind +
                     ": refused, because anybody on that network could send jobs: serve a loopback "
                     "address such as tcp://127.0.0.1:7400 (keys for other networks do not exist "
                     "yet)");
  }
  if (a.lease_timeout < 3 * a.heartbeat) {
    throw InputError(
        "--lease-timeout must be at least three times --heartbeat, or leases end "
        "before their workers can say that they are at work");
  }
  a.options.heartbeat = from_seconds(a.heartbeat);
  a.options.silence = 5 * a.options.heartbeat;
  a.options.lease_timeout = from_seconds(a.lease_timeout);
  a.options.fingerprint = trace_fingerprint();

  const auto log = spdlog::stderr_color_mt("coordinator");
  log->set_level(spdlog::level::from_str(a.log_level));
  const auto store = open_store(a.state);
  Coordinator coordinator(a.options, *store, log);
  ZmqServer server(a.bind, a.max_message_bytes);
  const SteadyClock clock;
  log->info("ParRay {} coordinator serves {}", PARRAY_VERSION, server.endpoint());
  std::cout << server.endpoint() << std::endl;
  run_actor(coordinator, server.link(), clock, [](Time) { return stop_requested(); });
  coordinator.leave("coordinator stopped");
  for (Delivery& goodbye : coordinator.take_outbox()) {
    server.link().send(goodbye.peer, std::move(goodbye.frames));
  }
  log->info("stopped");
  return 0;
}

}  // namespace

int main(int argc, char** argv) {
  try {
    CLI::App app("Serves render jobs to ParRay workers. Prints the address that it serves.",
                 "parray-coordinator");
    Arguments arguments;
    declare_options(app, arguments);
    return parray::daemon_main(app, argc, argv, [&] { return serve(arguments); });
  } catch (...) {  // not even the options could be made
    return 1;
  }
}
