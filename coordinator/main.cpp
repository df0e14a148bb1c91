// parray-coordinator: the service that owns jobs, pictures and leases.
#include <spdlog/spdlog.h>

#include <chrono>
#include <iostream>
#include <memory>
#include <random>
#include <utility>
#include <vector>

#include "common/base/cgroup_limits.h"
#include "common/base/cpu_count.h"
#include "common/base/error.h"
#include "common/log/log.h"
#include "common/process/command_line.h"
#include "common/process/run_main.h"
#include "common/process/stop_signal.h"
#include "common/trace/selfcheck/fingerprint.h"
#include "coordinator/disputes/referee_process.h"
#include "coordinator/http/http_service.h"
#include "coordinator/loop/coordinator.h"
#include "coordinator/loop/descriptors.h"
#include "coordinator/loop/key_watch.h"
#include "coordinator/loop/process_limits.h"
#include "coordinator/replica/state_owner.h"
#include "coordinator/store/state_commands.h"
#include "proto/merged_link.h"
#include "proto/tokens.h"
#include "proto/zmq_link.h"

namespace {

using namespace parray;
using namespace parray::coordinator;

struct Arguments {
  std::string bind = "tcp://127.0.0.1:7400";
  std::size_t max_message_bytes = default_max_message_bytes;
  std::string keys;
  bool insecure = false;
  StateOptions keeper;
  double takeover_after = 15;
  double lease_timeout = 10;
  double heartbeat = 1;
  LogOptions log;
  double memory_gib = static_cast<double>(usable_memory()) * 0x1p-31;
  std::size_t max_failures = 3;
  double spot_checks = -1;  ///< below 0: not given
  double disk_gib = 100;
  double user_disk_gib = 50;
  double keep_days = 90;
  double keep_lost_days = 30;
  std::string check;                ///< directory
  std::string repair;               ///< directory
  std::vector<std::string> backup;  ///< directory and target
  http::Options http;
  double http_body_mib = 256;
  double http_scene_gib = 2;
  CoordinatorOptions options;
};

constexpr const char* farm_group = "Farm";
constexpr const char* state_group = "State";
constexpr const char* tools_group = "Instead of serving";
constexpr const char* workers_group = "Workers";
constexpr const char* limits_group = "Limits";
constexpr const char* http_group = "HTTP";

void declare_http(CommandLine& line, Arguments& a) {
  const Option http =
      line.option(
              "--http", a.http.address,
              "Serve HTTP, too, at HOST:PORT (7480 is usual, 0 a free port): jobs, pictures and "
              "events under /api/v1, described by /api/v1/openapi.json. With --keys whoever asks "
              "needs a token (parray keygen DIR --token NAME)")
          .type_name("HOST:PORT")
          .group(http_group);
  line.option("--http-host", a.http.hosts,
              "A name by which browsers call this machine, beside localhost")
      .type_name("NAME")
      .one_value_each()
      .group(http_group)
      .needs(http);
  line.option("--webhook-host", a.http.webhook_hosts,
              "A host that may be told when jobs have ended (option webhook of a job)")
      .type_name("HOST")
      .one_value_each()
      .group(http_group)
      .needs(http);
  line.number("--http-streams", a.http.streams, 0, 10000, "Event streams served at once")
      .group(http_group)
      .needs(http)
      .show_default();
  line.number("--http-connections", a.http.connections, 1, 100000, "Connections of HTTP at once")
      .group(http_group)
      .needs(http)
      .show_default();
  line.number(
          "--http-connections-per-address", a.http.address_connections, 1, 100000,
          "Of one address, a proxy's, too. Whoever has not sent a request yet makes room for who "
          "comes later; /healthz and /readyz are answered all the same")
      .group(http_group)
      .needs(http)
      .show_default();
  line.number("--http-body", a.http_body_mib, 0.001, 1e6,
              "MiB of a scene that is sent, its files "
              "included")
      .group(http_group)
      .needs(http)
      .show_default();
  line.number("--http-parts", a.http.uploads.parts, 1, 100000, "Parts of a form")
      .group(http_group)
      .needs(http)
      .show_default();
  line.number("--http-scene-memory", a.http_scene_gib, 0.1, 1e6,
              "GiB that reading a scene that is sent may take, in a process of its own")
      .group(http_group)
      .needs(http)
      .show_default();
  line.number("--http-scene-seconds", a.http.uploads.child.seconds, 1, 100000,
              "Seconds of processor time that it may take")
      .group(http_group)
      .needs(http)
      .show_default();
}

void declare_limits(CommandLine& line, Arguments& a) {
  Limits& limits = a.options.limits;
  line.number("--max-jobs", limits.jobs, 1, 1000000,
              "Jobs kept; the oldest that has ended makes room")
      .show_default()
      .group(limits_group);
  line.number("--max-user-jobs", limits.user_jobs, 1, 1000000, "Unfinished jobs of one user")
      .show_default()
      .group(limits_group);
  line.number("--max-pixels", limits.pixels, 1, std::size_t{1} << 32, "Pixels of a picture")
      .show_default()
      .group(limits_group);
  line.number("--max-user-pixels", limits.user_pixels, 1, std::size_t{1} << 40,
              "Pixels of all unfinished jobs of one user")
      .show_default()
      .group(limits_group);
  line.number("--max-disk", a.disk_gib, 0.001, 1e6,
              "GiB below --state; jobs that have ended make room, the oldest first")
      .show_default()
      .group(limits_group);
  line.number("--max-user-disk", a.user_disk_gib, 0.001, 1e6, "GiB below --state of one user")
      .show_default()
      .group(limits_group);
  line.number("--keep-days", a.keep_days, 0.0001, 1e5, "Days that a job is kept once it has ended")
      .show_default()
      .group(limits_group);
  line.number("--keep-lost", a.keep_lost_days, 0.0001, 1e5,
              "Days that files which no record names are kept below lost/ of --state")
      .show_default()
      .group(limits_group);
  line.number("--max-requests", limits.requests, 1, 1000000,
              "Messages a second of one peer that is no worker; more are dropped")
      .show_default()
      .group(limits_group);
}

void declare_state(CommandLine& line, Arguments& a) {
  const Option state =
      line.option("--state", a.keeper.state,
                  "Directory for jobs, accepted rows and pictures, so that a coordinator started "
                  "again goes on; without it they end with the process")
          .type_name("DIR")
          .completes(Completes::directories)
          .group(state_group);
  line.flag("--wait", a.keeper.wait,
            "While another coordinator uses --state, stand by: serve as soon as that has ended")
      .needs(state)
      .group(state_group);
  line.option("--replicate-to", a.keeper.replicate_to,
              "Address of a standby on another machine, tcp://HOST:7401: nothing is acknowledged "
              "before it has it, too")
      .type_name("ADDRESS")
      .needs(state)
      .group(state_group);
  Option standby = line.option("--standby", a.keeper.standby,
                               "Stand by for the coordinator that says --replicate-to with this "
                               "address (tcp://*:7401): "
                               "keep a copy of its state, serve when it is silent")
                       .type_name("ADDRESS");
  standby.needs(state).group(state_group);
  line.flag(
          "--overwrite", a.keeper.overwrite,
          "Let a primary that was set back, to an older copy of its state, replace what only this "
          "standby has")
      .needs(standby)
      .group(state_group);
  line.flag("--serve-fenced", a.keeper.serve_fenced,
            "Serve a state from which a standby has taken over, as a farm of its own: jobs of both "
            "then have the same numbers")
      .needs(state)
      .group(state_group);
  line.number("--takeover-after", a.takeover_after, 1.0, 86400.0,
              "Seconds of silence after which a standby takes over, and after which a primary that "
              "does not reach its standby sends its workers there; give both the same")
      .needs(state)
      .show_default()
      .group(state_group);
}

void declare_tools(CommandLine& line, Arguments& a) {
  line.option("--check", a.check,
              "Read the state below DIR, print one line for each damage, and end with status 1 if "
              "there is any. Changes nothing; no coordinator may serve it meanwhile")
      .type_name("DIR")
      .completes(Completes::directories)
      .group(tools_group);
  line.option("--repair", a.repair,
              "Mend the state below DIR: build a lost or damaged database from the files beside "
              "it, and print what was done and what is lost. Replaced files move to DIR/lost")
      .type_name("DIR")
      .completes(Completes::directories)
      .group(tools_group);
  line.option("--backup", a.backup,
              "Copy the state below DIR, which a coordinator may be serving, to the new directory "
              "TARGET. To restore it, serve it with --state")
      .type_name("DIR TARGET")
      .completes(Completes::directories)
      .group(tools_group);
}

void declare_options(CommandLine& line, Arguments& a) {
  line.option("--coordinator,--bind", a.bind,
              "Address to serve: tcp://ADDRESS:PORT (port * for a free one)")
      .type_name("ADDRESS")
      .show_default()
      .group(farm_group);
  line.option("--keys", a.keys,
              "Directory of the farm's keys (parray keygen): only those that it names are heard")
      .type_name("DIR")
      .completes(Completes::directories)
      .environment("PARRAY_KEYS")
      .group(farm_group);
  line.flag("--insecure", a.insecure,
            "Serve other machines without keys: anybody there can send jobs and pose as a worker")
      .group(farm_group);
  declare_state(line, a);
  declare_tools(line, a);
  declare_http(line, a);
  declare_limits(line, a);
  line.number("--max-workers", a.options.max_workers, 1, 1000000, "Workers served at once")
      .show_default()
      .group(limits_group);
  line.number(
          "--memory", a.memory_gib, 0.001, 1e6,
          "GiB for pictures under way and, without --state, scenes and finished pictures; jobs "
          "beyond it wait. With --http an eighth is for pictures and scenes on their way (default: "
          "half of what it may use)")
      .group(limits_group);
  line.number("--max-failures", a.max_failures, 1, 1000,
              "A job fails when so many different machines have failed at the same part of it")
      .show_default()
      .group(workers_group);
  line.number("--spot-checks", a.spot_checks, 0.0, 1.0,
              "Share of the leases, 0 to 1, that another machine or the referee traces too, to "
              "compare the bits; of a machine's first 100 leases at least 0.1, unless it is 0 "
              "(default: 0.01, but none of workers on this machine under the same user)")
      .group(workers_group);
  line.number("--max-message-bytes", a.max_message_bytes, std::size_t{1} << 20,
              std::size_t{1} << 40,
              "Largest message taken; a scene or picture beyond it is refused")
      .show_default()
      .group(limits_group);
  line.number("--heartbeat", a.heartbeat, 0.05, 60.0,
              "Seconds between a worker's signs of life, n times that beyond n thousand workers; "
              "five times as long without one and it is lost")
      .show_default()
      .group(workers_group);
  line.number("--lease-timeout", a.lease_timeout, 0.1, 3600.0,
              "Seconds without progress after which a lease goes to another worker")
      .show_default()
      .group(workers_group);
  a.log.add_to(line, "What is told on stderr: this, and worse; debug: every lease");
  line.example("parray-coordinator --state /var/lib/parray",
               "for this machine's workers; started again, it goes on where it was");
  line.example("parray-coordinator --state /var/lib/parray --http 127.0.0.1:7480",
               "with a page for browsers, and an interface for programs");
  line.example(
      "parray-coordinator --coordinator 'tcp://*:7400' --keys farm --state /var/lib/parray",
      "for others, too, with the keys that parray keygen farm has made");
  line.example(
      "parray-coordinator --coordinator 'tcp://*:7400' --keys farm --state rows --standby "
      "'tcp://*:7401'",
      "stands by for the coordinator that says --replicate-to with this address");
}

Time from_seconds(double value) {
  return std::chrono::duration_cast<Time>(std::chrono::duration<double>(value));
}

double seconds_since_1970() {
  return std::chrono::duration<double>(std::chrono::system_clock::now().time_since_epoch()).count();
}

/// Anywhere: no other life's epochs are within reach.
Epoch random_epoch() {
  std::random_device device;
  return (Epoch{device()} << 30) + (Epoch{device()} & 0x3FFFFFFF) + 1;
}

/// Without keys only this machine is served, unless the user insists.
void refuse_in_the_clear(const Arguments& a, const std::string& option, const std::string& address,
                         const std::string& danger) {
  if (!address.empty() && !is_loopback(address) && a.keys.empty() && !a.insecure) {
    throw InputError(option + " " + address + ": refused, because anybody on that network could " +
                     danger +
                     ": make keys with parray keygen DIR and say --keys DIR (or --insecure, if "
                     "that is what you want)");
  }
}

void check(const Arguments& a) {
  for (const auto& [option, address] :
       {std::pair("--coordinator", a.bind), std::pair("--replicate-to", a.keeper.replicate_to)}) {
    if (address.find(',') != std::string::npos) {
      throw InputError(std::string(option) + " " + address +
                       ": must be one address; lists are for workers and clients");
    }
  }
  if (!a.keeper.standby.empty() && !a.keeper.replicate_to.empty()) {
    throw InputError("--standby and --replicate-to: a standby has no standby of its own");
  }
  refuse_in_the_clear(a, "--coordinator", a.bind, "send jobs and pose as a worker");
  if (!a.http.address.empty() && !is_loopback("tcp://" + a.http.address)) {
    refuse_in_the_clear(a, "--http", a.http.address, "send jobs and stop others'");
  }
  refuse_in_the_clear(a, "--standby", a.keeper.standby, "pose as the primary");
  refuse_in_the_clear(a, "--replicate-to", a.keeper.replicate_to, "read all jobs and pictures");
  if (a.lease_timeout < 3 * a.heartbeat) {
    throw InputError(
        "--lease-timeout must be at least three times --heartbeat, or leases end "
        "before their workers can say that they are at work");
  }
}

/// Null: none is wanted.
std::unique_ptr<http::HttpService> make_http_service(Arguments& a, InprocHub& hub,
                                                     const std::shared_ptr<spdlog::logger>& log) {
  if (a.http.address.empty()) return nullptr;
  a.http.keys = a.keys;
  a.http.state = a.keeper.state;
  a.http.requests = a.options.limits.requests;
  a.http.uploads.body_bytes = static_cast<std::uint64_t>(a.http_body_mib * 0x1p20);
  a.http.uploads.child.memory = static_cast<std::uint64_t>(a.http_scene_gib * 0x1p30);
  auto face = std::make_unique<http::HttpService>(a.http, hub, log);
  face->start();
  log->info("HTTP is served at http://{}", face->address());
  if (a.keys.empty() && !is_loopback("tcp://" + a.http.address)) {
    log->warn("--insecure: anybody who reaches {} can send jobs and stop others'", face->address());
  }
  return face;
}

/// Until a signal, or until a standby has taken over.
void serve_jobs(Arguments& a, StateOwner& keeper, const std::shared_ptr<spdlog::logger>& log) {
  a.options.heartbeat = from_seconds(a.heartbeat);
  a.options.silence = 5 * a.options.heartbeat;
  a.options.lease_timeout = from_seconds(a.lease_timeout);
  a.options.fingerprint = trace_fingerprint();
  a.options.first_epoch = random_epoch();

  keep_freed_blocks();
  allow_connections(a.options.max_workers, a.http.address.empty() ? 0 : a.http.connections);
  if (!a.keys.empty()) check_key_lists(a.keys);
  ZmqServer server(a.bind, a.max_message_bytes, a.keys);
  if (a.keys.empty() && !is_loopback(a.bind)) {
    log->warn("--insecure: anybody who reaches {} can send jobs and pose as a worker", a.bind);
  }
  a.options.memory = static_cast<std::uint64_t>(a.memory_gib * 0x1p30);
  if (!a.http.address.empty()) {
    constexpr std::uint64_t part = 8;
    a.http.memory = a.options.memory / part;
    a.options.memory -= a.http.memory;
  }
  a.options.max_failures = static_cast<std::uint32_t>(a.max_failures);
  a.options.limits.disk = static_cast<std::uint64_t>(a.disk_gib * 0x1p30);
  a.options.limits.user_disk = static_cast<std::uint64_t>(a.user_disk_gib * 0x1p30);
  a.options.limits.keep_seconds = a.keep_days * 24 * 3600;
  a.options.limits.keep_lost_seconds = a.keep_lost_days * 24 * 3600;
  a.options.wall_clock = seconds_since_1970;
  a.options.job_thread.wake = [&server] { server.link().wake(); };
  a.options.job_thread.threads = usable_cpus();
  if (keeper.replicates()) {
    log->info("nothing is acknowledged before the standby at {} has it", a.keeper.replicate_to);
    a.options.job_thread.idle_commits = seconds(1);
    a.options.release_after = a.keeper.takeover_after;
  }
  CoordinatorOptions options = a.options;
  constexpr double default_checks = 0.01;
  options.checks.share = a.spot_checks < 0 ? default_checks : a.spot_checks;
  options.checks.ours_too = a.spot_checks > 0;
  options.referee = std::make_shared<RefereeProcess>(
      RefereeProcess::Options{{}, a.options.fingerprint, [&server] { server.link().wake(); }});
  Coordinator coordinator(std::move(options), keeper.store(), log);
  const SteadyClock clock;
  log->info("ParRay {} coordinator serves {}", PARRAY_VERSION, server.endpoint());
  std::cout << server.endpoint() << std::endl;
  InprocHub hub([&server] { server.link().wake(); });
  MergedLink link(server.link(), hub.coordinator());
  const auto face = make_http_service(a, hub, log);
  KeyWatch key_watch(a.keys, log);
  DescriptorWatch descriptors(*log);
  run_actor(coordinator, link, clock, [&](Time now) {
    key_watch.look(now);
    descriptors.look(now);
    return interrupt_noted() || keeper.fenced();
  });
  if (keeper.fenced()) {
    return;
  }
  coordinator.leave("coordinator stopped");
  for (Delivery& goodbye : coordinator.take_outbox()) {
    link.send(goodbye.peer, std::move(goodbye.content));
  }
  log->info("stopped");
}

int serve(Arguments& a) {
  check(a);
  const auto log = make_log("coordinator", a.log);
  a.keeper.keys = a.keys;
  a.keeper.takeover_after = from_seconds(a.takeover_after);
  StateOwner keeper(a.keeper, *log, check_interrupted);
  try {
    serve_jobs(a, keeper, log);
  } catch (const RunError&) {
    if (!keeper.fenced()) throw;
  }
  if (keeper.fenced()) {
    keeper.remember_fence();
    throw RunError("fenced: the standby at " + a.keeper.replicate_to +
                   " has taken over and serves as a later generation");
  }
  return 0;
}

}  // namespace

int main(int argc, char** argv) {
  const Program program = {"parray-coordinator",
                           "Serve render jobs to workers; prints the address that it serves",
                           PARRAY_VERSION};
  Arguments arguments;
  return run_main(program, argc, argv, [&](CommandLine& line) {
    declare_options(line, arguments);
    return [&] {
      if (!arguments.check.empty()) {
        return check_command(arguments.check);
      }
      if (!arguments.repair.empty()) {
        return repair_command(arguments.repair, seconds_since_1970());
      }
      if (!arguments.backup.empty()) {
        return backup_command(arguments.backup, seconds_since_1970());
      }
      note_signals();
      return serve(arguments);
    };
  });
}
