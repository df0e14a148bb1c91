#include "cli/farm/embedded.h"

#include <spdlog/sinks/stdout_sinks.h>
#include <spdlog/spdlog.h>

#include <algorithm>
#include <atomic>
#include <exception>
#include <functional>
#include <future>
#include <limits>
#include <mutex>
#include <string>
#include <system_error>
#include <thread>
#include <utility>

#include "common/base/error.h"
#include "common/trace/selfcheck/fingerprint.h"
#include "coordinator/loop/coordinator.h"
#include "proto/inproc_link.h"
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

/// A thread. The owner can wait for its end with a time limit.
class WatchedThread {
 public:
  explicit WatchedThread(auto work) {
    std::packaged_task<void()> task(std::move(work));
    ended_ = task.get_future();
    try {
      thread_ = std::thread(std::move(task));
    } catch (const std::system_error& error) {
      throw RunError(std::string("starting a thread: ") + error.what());
    }
  }
  ~WatchedThread() { thread_.join(); }
  WatchedThread& operator=(WatchedThread&&) = delete;

  [[nodiscard]] bool ended_within(Time patience) const {
    return ended_.wait_for(patience) == std::future_status::ready;
  }

 private:
  std::future<void> ended_;
  std::thread thread_;
};

}  // namespace

class EmbeddedFarm::Impl {
 public:
  Impl(std::uint32_t threads, std::function<PictureJudge(const std::string&)> judge_of)
      : fingerprint_(trace_fingerprint()), threads_(threads), judge_of_(std::move(judge_of)) {
    start(coordinator_thread_, &Impl::run_coordinator);
    try {
      start(worker_thread_, &Impl::run_worker);
    } catch (...) {
      request_stop();  // otherwise joining the coordinator's thread would never end
      throw;
    }
  }
  ~Impl() { request_stop(); }
  Impl& operator=(Impl&&) = delete;

  std::unique_ptr<Link> connect() { return hub_.connect(); }
  [[nodiscard]] std::shared_ptr<AcceleratorCache> accelerators() const { return accelerators_; }

  void check() const {
    const std::scoped_lock lock(mutex_);
    if (failure_) std::rethrow_exception(failure_);
  }

  bool stop(Time patience) {
    request_stop();
    const SteadyClock clock;
    const Time end = clock.now() + patience;
    return worker_thread_->ended_within(patience) &&
           coordinator_thread_->ended_within(std::max(end - clock.now(), Time(0)));
  }

 private:
  void request_stop() {
    stop_ = true;
    hub_.coordinator().wake();
    worker_link_->wake();
  }

  void start(std::unique_ptr<WatchedThread>& thread, void (Impl::*work)()) {
    thread = std::make_unique<WatchedThread>([this, work] {
      try {
        (this->*work)();
      } catch (...) {
        const std::scoped_lock lock(mutex_);
        failure_ = std::current_exception();
      }
    });
  }

  void run_coordinator() {
    CoordinatorOptions options = patient_options(fingerprint_);
    options.job_thread.wake = [this] { hub_.coordinator().wake(); };
    options.job_thread.threads = static_cast<int>(threads_);
    if (judge_of_) options.judge_of = [this](const JobRecord& job) { return judge_of_(job.scene); };
    Coordinator coordinator(std::move(options), nullptr, make_logger());
    run_actor(coordinator, hub_.coordinator(), SteadyClock(),
              [this](Time) { return stop_.load(); });
  }

  void run_worker() {
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

  const std::string fingerprint_;
  const std::uint32_t threads_;
  const std::function<PictureJudge(const std::string&)> judge_of_;
  const std::shared_ptr<AcceleratorCache> accelerators_ = std::make_shared<AcceleratorCache>();
  InprocHub hub_;
  std::unique_ptr<Link> worker_link_ = hub_.connect();
  std::atomic<bool> stop_ = false;
  mutable std::mutex mutex_;  // guards failure_
  std::exception_ptr failure_;
  // Last, so that the threads end before the members that they use.
  std::unique_ptr<WatchedThread> coordinator_thread_;
  std::unique_ptr<WatchedThread> worker_thread_;
};

EmbeddedFarm::EmbeddedFarm(std::uint32_t threads,
                           std::function<PictureJudge(const std::string&)> judge_of)
    : impl_(std::make_unique<Impl>(threads, std::move(judge_of))) {}
EmbeddedFarm::~EmbeddedFarm() = default;
std::unique_ptr<Link> EmbeddedFarm::connect() { return impl_->connect(); }
std::shared_ptr<AcceleratorCache> EmbeddedFarm::accelerators() const {
  return impl_->accelerators();
}
void EmbeddedFarm::check() const { impl_->check(); }
bool EmbeddedFarm::stop(Time patience) { return impl_->stop(patience); }

}  // namespace parray::farm
