#include "coordinator/loop/job_thread.h"

#include <omp.h>

#include <algorithm>
#include <iterator>
#include <new>

#include "common/math/float_mode.h"

namespace parray::coordinator {

using Closures = std::vector<std::function<void()>>;

/// Runs the task. If it throws, returns `failed` as its completion.
static JobThread::Completion completion_of(const JobThread::Task& task,
                                           const JobThread::Failed& failed) {
  std::string why;
  try {
    return task();
  } catch (const std::bad_alloc&) {
    why = "not enough memory";
  } catch (const std::exception& error) {
    why = error.what();
  }
  return {[failed, why] { failed(why); }};
}

JobThread::JobThread(Store* store, Options options) : store_(store), options_(std::move(options)) {
  if (options_.threaded) thread_ = std::thread([this] { run(); });
}

JobThread::~JobThread() {
  {
    const std::scoped_lock lock(mutex_);
    quit_ = true;
  }
  changed_.notify_all();
  if (thread_.joinable()) thread_.join();
}

void JobThread::give(Task task, Failed failed) {
  Given given{std::move(task), std::move(failed)};
  if (!options_.threaded) {
    run_task(std::move(given));
    return;
  }
  {
    const std::scoped_lock lock(mutex_);
    waiting_.push_back(std::move(given));
  }
  changed_.notify_all();
}

void JobThread::run_task(Given given) {
  Completion completion = completion_of(given.task, given.failed);
  given = {};  // destroys what the task held in this thread, not in the loop's
  const std::scoped_lock lock(mutex_);
  unsaved_ = store_ != nullptr;
  if (completion.done) finished_.push_back(std::move(completion.done));
  if (completion.kept) {
    (store_ == nullptr ? finished_ : uncommitted_).push_back(std::move(completion.kept));
  }
}

void JobThread::commit() {
  if (store_ == nullptr) return;
  Closures waiting;
  {
    const std::scoped_lock lock(mutex_);
    waiting = std::exchange(uncommitted_, {});
  }
  std::string blocked;
  try {
    store_->commit();
  } catch (const StorageFull& full) {
    blocked = full.what();
  }
  const std::scoped_lock lock(mutex_);
  blocked_ = blocked;
  unsaved_ = !blocked.empty();
  std::ranges::move(waiting, std::back_inserter(blocked.empty() ? finished_ : uncommitted_));
}

void JobThread::settle(Time most) {
  if (!options_.threaded) {
    commit();
    return;
  }
  std::unique_lock lock(mutex_);
  changed_.wait_for(lock, most,
                    [this] { return quit_ || (waiting_.empty() && !busy_ && !unsaved_); });
}

void JobThread::run_finished() {
  if (!options_.threaded) commit();
  // Completions queue tasks, which without a thread run immediately.
  for (;;) {
    Closures finished;
    {
      const std::scoped_lock lock(mutex_);
      if (failure_) std::rethrow_exception(failure_);
      finished = std::exchange(finished_, {});
    }
    if (finished.empty()) return;
    for (const auto& next : finished) next();
    if (!options_.threaded) commit();
  }
}

std::string JobThread::blocked() const {
  const std::scoped_lock lock(mutex_);
  return blocked_;
}

std::size_t JobThread::backlog() const {
  const std::scoped_lock lock(mutex_);
  return waiting_.size() + (busy_ ? 1 : 0);
}

void JobThread::run() {
  const FloatMode ieee;
  omp_set_num_threads(options_.threads);
  const SteadyClock clock;
  const auto after_idling = [&] {
    return options_.idle_commits == never ? never : clock.now() + options_.idle_commits;
  };
  Time commit_at = store_ == nullptr ? never : after_idling();
  std::unique_lock lock(mutex_);
  while (!quit_) {
    const bool due = commit_at <= clock.now();
    if (waiting_.empty() && !due) {
      const Time pause = commit_at == never ? Time(seconds(3600)) : commit_at - clock.now();
      changed_.wait_for(lock, pause, [this] { return quit_ || !waiting_.empty(); });
      continue;
    }
    Given next;
    if (!waiting_.empty() && !due) {
      next = std::move(waiting_.front());
      waiting_.pop_front();
    }
    busy_ = true;
    lock.unlock();
    try {
      if (next.task) {
        run_task(std::move(next));
        if (store_ != nullptr) {
          commit_at = std::min(commit_at, clock.now() + options_.commit_interval);
        }
      } else {
        commit();
        commit_at = blocked().empty() ? after_idling() : clock.now() + seconds(1);
      }
    } catch (...) {
      const std::scoped_lock guard(mutex_);
      failure_ = std::current_exception();
      quit_ = true;
    }
    if (options_.wake) options_.wake();
    lock.lock();
    busy_ = false;
    changed_.notify_all();  // for settle()
  }
}

}  // namespace parray::coordinator
