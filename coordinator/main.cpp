// parray-coordinator: the service that owns jobs, pictures and leases.
#include <spdlog/spdlog.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <filesystem>
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
#include "common/scene/limits.h"
#include "common/trace/selfcheck/fingerprint.h"
#include "coordinator/disputes/referee_process.h"
#include "coordinator/http/http_service.h"
#include "coordinator/loop/coordinator.h"
#include "coordinator/loop/key_watch.h"
#include "coordinator/loop/process_limits.h"
#include "coordinator/replica/state_owner.h"
#include "coordinator/store/state_tools.h"
#include "proto/address_list.h"
#include "proto/inproc_link.h"
#include "proto/keys.h"
#include "proto/zmq_link.h"

namespace {

using namespace parray;
using namespace parray::coordinator;

struct Arguments {
  std::string bind = "tcp://127.0.0.1:7400";
  std::size_t max_message_bytes = default_max_message_bytes;
  std::string keys;
  bool insecure = false;
  StateOptions state;
  double takeover_after = 15;
  double lease_timeout = 10;
  double heartbeat = 1;
  LogOptions log;
  double memory_gib = static_cast<double>(usable_memory()) * 0x1p-31;
  std::size_t max_failures = 3;
  double spot_checks = -1;  ///< negative: not given
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

/// Heading of the options that are tools in the help.
constexpr const char* tools_group = "Instead of serving";

/// Declares a number whose present value is the default that the help shows.
template <typename Number>
Option number(CommandLine& line, const char* names, Number& target,
              std::type_identity_t<Number> least, std::type_identity_t<Number> most,
              const char* text) {
  return line.number(names, target, least, most, text).show_default();
}

/// Declares an option whose value is a directory.
Option directory(CommandLine& line, const char* names, std::string& target, const char* text) {
  return line.option(names, target, text).type_name("DIR").completes(Completes::directories);
}

void declare_http(CommandLine& line, Arguments& a) {
  line.section("HTTP");
  const Option http =
      line.option("--http", a.http.address,
                  "Also serve HTTP at HOST:PORT (usually 7480; 0: a free port): jobs, pictures and "
                  "events under /api/v1 (see /api/v1/openapi.json), and a page for browsers. With "
                  "--keys, requests need a token (parray keygen DIR --token NAME)")
          .type_name("HOST:PORT");
  line.section("HTTP", http);
  line.option("--http-host", a.http.hosts,
              "Name of this machine that browsers may use, in addition to localhost")
      .type_name("NAME")
      .one_value_each();
  line.option("--webhook-host", a.http.webhook_hosts,
              "Host that may receive a request when a job ends (option webhook of the job)")
      .type_name("HOST")
      .one_value_each();
  number(line, "--http-streams", a.http.streams, 0, 10000, "Maximum number of event streams");
  number(line, "--http-connections", a.http.connections, 1, 100000, "Maximum HTTP connections");
  number(line, "--http-connections-per-address", a.http.address_connections, 1, 100000,
         "Maximum number of HTTP connections of one address, also of a proxy. New ones replace "
         "those without a request yet; /healthz and /readyz are always answered");
  number(line, "--http-body", a.http_body_mib, 0.001, 1e6,
         "Largest uploaded scene with its files in MiB");
  number(line, "--http-parts", a.http.uploads.parts, 1, 100000,
         "Maximum number of parts of a form");
  number(line, "--http-scene-memory", a.http_scene_gib, 0.1, 1e6,
         "Memory in GiB for the process that reads an uploaded scene");
  number(line, "--http-scene-seconds", a.http.uploads.child.seconds, 1, 100000,
         "Processor time in seconds for the process that reads an uploaded scene");
}

void declare_limits(CommandLine& line, Arguments& a) {
  Limits& limits = a.options.limits;
  line.section("Limits");
  number(line, "--max-jobs", limits.jobs, 1, 1000000,
         "Maximum number of jobs; a series counts as one. At the maximum, a new job deletes the "
         "oldest ended job with its picture, and is refused if none has ended");
  number(line, "--max-user-jobs", limits.user_jobs, 1, 1000000,
         "Maximum number of unfinished jobs of one user");
  number(line, "--max-pixels", limits.pixels, 1, limits::max_pixels,
         "Maximum pixels of a picture; it can only be lowered");
  number(line, "--max-user-pixels", limits.user_pixels, 1, std::size_t{1} << 40,
         "Maximum number of pixels of all unfinished jobs of one user");
  number(line, "--max-disk", a.disk_gib, 0.001, 1e6,
         "Maximum GiB below --state. Above it, ended jobs are deleted with their pictures, the "
         "oldest first; if that is not enough, new jobs are refused");
  number(line, "--max-user-disk", a.user_disk_gib, 0.001, 1e6,
         "Maximum GiB of one user below --state");
  number(line, "--keep-days", a.keep_days, 0.0001, 1e5,
         "Days until an ended job is deleted, counted while the coordinator serves");
  number(line, "--keep-lost", a.keep_lost_days, 0.0001, 1e5,
         "Days until files that were set aside in lost/ of --state are deleted, counted while the "
         "coordinator serves");
  number(line, "--max-requests", limits.requests, 1, 1000000,
         "Maximum number of messages per second of one client; more are dropped");
}

void declare_state(CommandLine& line, Arguments& a) {
  line.section("State");
  const Option state =
      directory(line, "--state", a.state.state,
                "Directory for jobs, results and pictures, from which a restarted coordinator "
                "continues; without it they end with the process");
  line.section("State", state);
  line.flag("--wait", a.state.wait,
            "While another coordinator uses --state, wait; serve as soon as that has ended");
  line.option("--replicate-to", a.state.replicate_to,
              "Address of a standby on another machine, tcp://HOST:7401: acknowledge only what the "
              "standby has stored, too")
      .type_name("ADDRESS");
  const Option standby =
      line.option("--standby", a.state.standby,
                  "Address for a primary's --replicate-to (tcp://*:7401): keep a copy of "
                  "the primary's state, and serve when the primary is silent")
          .type_name("ADDRESS");
  line.section("State", standby);
  line.flag("--overwrite", a.state.overwrite,
            "Let a primary that was set back to an older copy of its state delete what only this "
            "standby has");
  line.section("State", state);
  line.flag("--serve-fenced", a.state.serve_fenced,
            "Serve the older state of a primary although its standby has taken over. The two are "
            "then separate farms, whose jobs have the same numbers");
  number(line, "--takeover-after", a.takeover_after, 1.0, 86400.0,
         "Seconds of silence after which a standby takes over, or a primary sends its workers to "
         "the standby; use the same value for both");
}

void declare_tools(CommandLine& line, Arguments& a) {
  line.section(tools_group);
  directory(line, "--check", a.check,
            "Read the state below DIR, print one line for each damage, and exit with status 1 if "
            "there is any. Changes nothing; no coordinator may serve the state meanwhile");
  directory(line, "--repair", a.repair,
            "Repair the state below DIR: rebuild a lost or damaged database from other files, and "
            "print repairs and losses. Replaced files move to DIR/lost");
  line.option(
          "--backup", a.backup,
          "Copy the state below DIR to the new directory TARGET. A coordinator may be serving the "
          "state. To restore the copy, serve it with --state")
      .type_name("DIR TARGET")
      .completes(Completes::directories);
}

void declare_options(CommandLine& line, Arguments& a) {
  line.section("Farm");
  line.option("--coordinator,--bind", a.bind,
              "Address to serve: tcp://ADDRESS:PORT (port * for a free one)")
      .type_name("ADDRESS")
      .show_default();
  directory(line, "--keys", a.keys,
            "Directory of the farm's keys (parray keygen): accept only peers with these keys")
      .environment("PARRAY_KEYS");
  line.flag("--insecure", a.insecure,
            "Serve other machines without keys: anyone there can send jobs and pose as a worker");
  declare_state(line, a);
  declare_tools(line, a);
  declare_http(line, a);
  declare_limits(line, a);
  number(line, "--max-workers", a.options.max_workers, 1, 1000000, "Maximum number of workers");
  line.number("--memory", a.memory_gib, 0.001, 1e6,
              "GiB of memory for unfinished pictures and, without --state, scenes and finished "
              "pictures; further jobs wait. With --http, downloads and uploads get an eighth of it "
              "(default: half of the available memory)");
  line.section("Workers");
  number(line, "--max-failures", a.max_failures, 1, 1000,
         "A job fails when so many machines that trace other parts of it have failed at the same "
         "part. It also fails when all machines have failed there, if they are so many, or if each "
         "has at least two failures for each of its workers");
  line.number("--spot-checks", a.spot_checks, 0.0, 1.0,
              "Share of the leases, 0 to 1, that another machine traces again, to compare the bits "
              "(without another machine, a process of this coordinator traces some of the cells); "
              "at least 0.1 of a machine's first 100 leases, and of the first 20 after each start "
              "of a worker, unless it is 0 (default: 0.01, but 0 for workers of the same user on "
              "this machine)");
  number(line, "--max-message-bytes", a.max_message_bytes, std::size_t{1} << 20,
         std::size_t{1} << 40,
         "Maximum number of bytes of a message to this coordinator, and so of a scene; it "
         "disconnects senders of larger ones")
      .group("Limits");
  number(line, "--heartbeat", a.heartbeat, 0.05, 60.0,
         "Seconds between a worker's heartbeats, up to n times that with n thousand workers; a "
         "worker is lost after five times as long without a message");
  number(line, "--lease-timeout", a.lease_timeout, 0.1, 3600.0,
         "Seconds without progress after which a lease goes to another worker");
  a.log.add_to(line, "Lowest level of messages on stderr; debug shows every lease");
  line.example("parray-coordinator --state /var/lib/parray",
               "serves workers of this machine and continues after a restart");
  line.example("parray-coordinator --state /var/lib/parray --http 127.0.0.1:7480",
               "also serves a page for browsers and an interface for programs");
  line.example(
      "parray-coordinator --coordinator 'tcp://*:7400' --keys farm --state /var/lib/parray",
      "also serves other machines that have keys; parray keygen farm makes the keys in the "
      "directory farm");
  line.example(
      "parray-coordinator --coordinator 'tcp://*:7400' --keys farm --state /var/lib/parray "
      "--standby 'tcp://*:7401'",
      "is the standby of a primary that runs with --replicate-to tcp://HOST:7401; HOST is this "
      "machine");
}

double seconds_since_1970() {
  return std::chrono::duration<double>(std::chrono::system_clock::now().time_since_epoch()).count();
}

/// Returns a random first epoch, so that no earlier process has used the same epochs.
Epoch random_epoch() {
  std::random_device device;
  return (Epoch{device()} << 30) + (Epoch{device()} & 0x3FFFFFFF) + 1;
}

/// Throws InputError for an address of other machines without --keys and --insecure.
void refuse_without_keys(const Arguments& a, const std::string& option, const std::string& address,
                         const std::string& danger) {
  if (!address.empty() && !is_loopback(address) && a.keys.empty() && !a.insecure) {
    throw InputError(option + " " + address + ": refused, because anyone on that network could " +
                     danger +
                     ": make keys with parray keygen DIR and use --keys DIR, or use --insecure to "
                     "accept the risk");
  }
}

/// Throws InputError unless `address` is empty or one address with a port; see has_port().
/// `served`: the port may be *.
void check_address(const std::string& option, const std::string& address, bool served) {
  if (address.find(',') != std::string::npos) {
    throw InputError(option + " " + address +
                     ": must be one address: only workers and clients accept a list");
  }
  if (!has_port(address) && !(served && address.ends_with(":*"))) {
    throw InputError(option + " " + address + ": the port must be a number from 1 to 65535" +
                     (served ? ", or * for a free one" : "") +
                     ": write an address like tcp://127.0.0.1:7400");
  }
}

void check(const Arguments& a) {
  check_address("--coordinator", a.bind, true);
  check_address("--standby", a.state.standby, true);
  check_address("--replicate-to", a.state.replicate_to, false);
  http::check_address(a.http.address);
  if (!a.state.standby.empty() && !a.state.replicate_to.empty()) {
    throw InputError(
        "--standby and --replicate-to exclude each other: a standby cannot have a standby");
  }
  refuse_without_keys(a, "--coordinator", a.bind, "send jobs and pose as a worker");
  if (!a.http.address.empty() && !is_loopback("tcp://" + a.http.address)) {
    refuse_without_keys(a, "--http", a.http.address, "send jobs and stop all jobs");
  }
  refuse_without_keys(a, "--standby", a.state.standby, "pose as the primary");
  refuse_without_keys(a, "--replicate-to", a.state.replicate_to, "read all jobs and pictures");
  if (a.lease_timeout < 3 * a.heartbeat) {
    throw InputError(
        "--lease-timeout must be at least three times --heartbeat: otherwise leases end before the "
        "heartbeats of their workers arrive");
  }
}

/// Returns the address that workers of other machines use: that of this machine in place of all
/// addresses. `names`: of this machine, for browsers.
std::string worker_address(const std::string& endpoint, const std::vector<std::string>& names) {
  for (const std::string_view any : {"tcp://0.0.0.0:", "tcp://[::]:"}) {
    if (endpoint.starts_with(any)) {
      std::array<char, 256> host{};
      gethostname(host.data(), host.size() - 1);
      return "tcp://" + (names.empty() ? std::string(host.data()) : names.front()) +
             endpoint.substr(any.size() - 1);
    }
  }
  return endpoint;
}

/// Starts the HTTP service. Does nothing without --http.
http::HttpService start_http(Arguments& a, InprocHub& hub, const std::string& endpoint,
                             const std::shared_ptr<spdlog::logger>& log) {
  if (a.http.address.empty()) return {};
  a.http.worker_address = worker_address(endpoint, a.http.hosts);
  a.http.keys = a.keys;
  a.http.state = a.state.state;
  a.http.requests = a.options.limits.requests;
  a.http.uploads.body_bytes = static_cast<std::uint64_t>(a.http_body_mib * 0x1p20);
  a.http.uploads.child.memory = static_cast<std::uint64_t>(a.http_scene_gib * 0x1p30);
  http::HttpService service = http::serve_http(a.http, hub, log);
  log->info("HTTP is served at http://{}", service.address);
  if (a.keys.empty() && !is_loopback("tcp://" + a.http.address)) {
    log->warn("--insecure: anyone who reaches {} can send and stop jobs", service.address);
  }
  return service;
}

/// Serves until a signal arrives or the standby has taken over.
void serve_jobs(Arguments& a, StateOwner& state, const std::shared_ptr<spdlog::logger>& log) {
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
    log->warn("--insecure: anyone who reaches {} can send jobs and pose as a worker", a.bind);
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
  if (state.replicates()) {
    log->info("acknowledging only what the standby at {} has stored", a.state.replicate_to);
    a.options.job_thread.idle_commits = seconds(1);
    a.options.release_after = a.state.takeover_after;
  }
  CoordinatorOptions options = a.options;
  constexpr double default_checks = 0.01;
  options.checks.share = a.spot_checks < 0 ? default_checks : a.spot_checks;
  options.checks.ours_too = a.spot_checks > 0;
  options.referee = std::make_shared<RefereeProcess>(
      RefereeProcess::Options{{}, a.options.fingerprint, [&server] { server.link().wake(); }});
  constexpr const char* webhooks_note = "webhooks";
  if (state.store() != nullptr) a.http.webhooks = state.store()->note(webhooks_note);
  Coordinator coordinator(std::move(options), state.store(), log);
  if (state.store() != nullptr) {
    a.http.keep_webhooks = [&coordinator](std::string text) {
      return coordinator.keep_note(webhooks_note, std::move(text));
    };
  }
  const SteadyClock clock;
  log->info("ParRay {} coordinator serves {}", PARRAY_VERSION, server.endpoint());
  std::cout << server.endpoint() << std::endl;
  InprocHub hub([&server] { server.link().wake(); });
  MergedLink link(server.link(), hub.coordinator());
  const auto service = start_http(a, hub, server.endpoint(), log);
  KeyWatch key_watch(a.keys, log);
  DescriptorWatch descriptors(*log);
  run_actor(coordinator, link, clock, [&](Time now) {
    key_watch.look(now);
    descriptors.look(now);
    return interrupt_noted() || state.fenced();
  });
  if (state.fenced()) return;
  coordinator.leave("coordinator stopped");
  for (Delivery& bye : coordinator.take_outbox()) link.send(bye.peer, std::move(bye.content));
  coordinator.keep_progress();
  log->info("stopped");
}

int serve(Arguments& a) {
  check(a);
  const auto log = make_log("coordinator", a.log);
  a.state.keys = a.keys;
  a.state.takeover_after = from_seconds(a.takeover_after);
  StateOwner state(a.state, *log, check_interrupted);
  try {
    serve_jobs(a, state, log);
  } catch (const RunError&) {
    if (!state.fenced()) throw;
  }
  if (state.fenced()) {
    state.remember_fence();
    throw RunError("fenced: the standby at " + a.state.replicate_to +
                   " has taken over: to make this the new standby, replace --replicate-to by "
                   "--standby, and restart the other coordinator with --replicate-to");
  }
  return 0;
}

/// Throws InputError for options besides that of a tool, because a tool ignores them. Accepts
/// --state with the tool's directory: a container's program may be started with that option.
void check_alone(const CommandLine& line, const Arguments& a) {
  const std::vector<GivenOption> given = line.given_options();
  const auto tool = std::ranges::find(given, tools_group, &GivenOption::group);
  if (tool == given.end()) return;
  const auto is_state = [&](const std::string& directory) {
    return (std::filesystem::path(directory) / "").lexically_normal() ==
           (std::filesystem::path(a.state.state) / "").lexically_normal();
  };
  const bool same_state =
      is_state(a.check) || is_state(a.repair) || (!a.backup.empty() && is_state(a.backup.front()));
  for (const GivenOption& other : given) {
    if (other.name == tool->name || (other.name == "--state" && same_state)) continue;
    throw InputError(other.name + " has no effect with " + tool->name +
                     ": leave out one of the two");
  }
}

}  // namespace

int main(int argc, char** argv) {
  const Program program = {"parray-coordinator",
                           "Serve render jobs to workers; prints the address of the service",
                           PARRAY_VERSION};
  Arguments arguments;
  return run_main(program, argc, argv, [&](CommandLine& line) {
    declare_options(line, arguments);
    return [&arguments, &line] {
      check_alone(line, arguments);
      if (!arguments.check.empty()) return check_command(arguments.check);
      if (!arguments.repair.empty()) return repair_command(arguments.repair, seconds_since_1970());
      if (!arguments.backup.empty()) return backup_command(arguments.backup, seconds_since_1970());
      note_signals();
      return serve(arguments);
    };
  });
}
