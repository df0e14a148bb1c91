#include "cli/farm/embedded.h"

#include <spdlog/sinks/stdout_sinks.h>
#include <spdlog/spdlog.h>

#include <algorithm>
#include <limits>
#include <system_error>
#include <utility>

#include "common/base/error.h"
#include "common/trace/selfcheck/fingerprint.h"
#include "coordinator/loop/coordinator.h"
#include "worker/team.h"
#include "worker/worker.h"

namespace parray::farm {
namespace {

/// Returns a private logger. The default logger belongs to the program that uses this library.
std::shared_ptr<spdlog::logger> make_logger() {
  auto log = std::make_shared<spdlog::logger>("embedded",
                                              std::make_shared<spdlog::sinks::stderr_sink_mt>());
  log->set_level(spdlog::level::warn);
  log->set_pattern("parray: %l: %v");
  return log;
}

/// Returns options with long timeouts. Inside one process no worker gets lost, so long timeouts
/// cost nothing, and leases survive while the process is stopped.
CoordinatorOptions patient_options(const std::string& fingerprint) {
  CoordinatorOptions options;
  options.silence = seconds(600);  // the longest that the protocol allows
  options.lease_timeout = std::chrono::hours(24);
  options.fingerprint = fingerprint;
  options.memory =
      std::numeric_limits<std::uint64_t>::max() / 2;  // no limit for the user's own job
  options.limits.pixels = options.limits.user_pixels = std::numeric_limits<std::size_t>::max();
  options.waiting_counts = true;  // a time limit includes waiting: there are no other jobs
  options.max_failures = 1;       // no other worker could try
  options.on_quarantine = [](const std::string& reason) {
    throw RunError("this machine computed wrong bits (" + reason +
                   "): test it with parray doctor --extremes");
  };
  return options;
}

}  // namespace

EmbeddedFarm::EmbeddedFarm(std::uint32_t threads,
                           std::function<PictureJudge(const std::string&)> judge_of)
    : fingerprint_(trace_fingerprint()), threads_(threads), judge_of_(std::move(judge_of)) {
  coordinator_thread_ = start(&EmbeddedFarm::run_coordinator);
  try {
    worker_thread_ = start(&EmbeddedFarm::run_worker);
  } catch (...) {
    request_stop();  // otherwise waiting for the coordinator's thread would never end
    throw;
  }
}

void EmbeddedFarm::check() const {
  const std::scoped_lock lock(mutex_);
  if (failure_) std::rethrow_exception(failure_);
}

bool EmbeddedFarm::stop(Time patience) {
  request_stop();
  const SteadyClock clock;
  const Time end = clock.now() + patience;
  return worker_thread_.wait_for(patience) == std::future_status::ready &&
         coordinator_thread_.wait_for(std::max(end - clock.now(), Time(0))) ==
             std::future_status::ready;
}

void EmbeddedFarm::request_stop() {
  stop_ = true;
  hub_.coordinator().wake();
  worker_link_->wake();
}

std::future<void> EmbeddedFarm::start(void (EmbeddedFarm::*work)()) {
  try {
    return std::async(std::launch::async, [this, work] {
      try {
        (this->*work)();
      } catch (...) {
        const std::scoped_lock lock(mutex_);
        failure_ = std::current_exception();
      }
    });
  } catch (const std::system_error& error) {
    throw RunError(std::string("starting a thread: ") + error.what());
  }
}

void EmbeddedFarm::run_coordinator() {
  CoordinatorOptions options = patient_options(fingerprint_);
  options.job_thread.wake = [this] { hub_.coordinator().wake(); };
  options.job_thread.threads = static_cast<int>(threads_);
  if (judge_of_) options.judge_of = [this](const JobRecord& job) { return judge_of_(job.scene); };
  Coordinator coordinator(std::move(options), nullptr, make_logger());
  run_actor(coordinator, hub_.coordinator(), SteadyClock(), [this](Time) { return stop_.load(); });
}

void EmbeddedFarm::run_worker() {
  ThreadTeam team(
      static_cast<int>(threads_), [this] { worker_link_->wake(); }, accelerators_);
  WorkerOptions options;
  options.name = "embedded";
  options.instance = "1";
  options.threads = threads_;
  options.fingerprint = fingerprint_;
  options.in_process = true;
  Worker worker(options, team);
  run_actor(worker, *worker_link_, SteadyClock(), [&](Time) {
    if (!worker.refused().empty()) throw RunError("starting to render: " + worker.refused());
    return stop_.load();
  });
  team.abandon();
}

}  // namespace parray::farm
