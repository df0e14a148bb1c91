#include "coordinator/loop/job_thread.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <atomic>
#include <condition_variable>
#include <future>
#include <mutex>
#include <new>
#include <string>
#include <utility>
#include <vector>

#include "common/base/error.h"
#include "tests/support/crash_store.h"
#include "tests/support/rooms.h"

namespace parray {
namespace {

using test::CrashStore;

/// A job thread whose loop is the test's thread.
class Room {
 public:
  Room(Store* store, bool threaded)
      : room(store, {threaded, [this] { rung_.release(); }, milliseconds(1)}) {}

  /// Runs completions until `done`.
  template <typename Done>
  void run_until(Done done) {
    room.run_finished();
    while (!done()) {
      rung_.acquire();  // rung once for each task and commit
      room.run_finished();
    }
  }

 private:
  struct Bell {
    void release() {
      const std::scoped_lock lock(mutex);
      ++count;
      changed.notify_all();
    }
    void acquire() {
      std::unique_lock lock(mutex);
      changed.wait(lock, [this] { return count > 0; });
      --count;
    }
    std::mutex mutex;
    std::condition_variable changed;
    int count = 0;
  };
  Bell rung_;

 public:
  JobThread room;

  /// Queues a task that does not throw.
  void give(JobThread::Task task) {
    room.give(std::move(task), [](const std::string& why) { FAIL(why); });
  }
};

/// A task that puts a job's record.
JobThread::Task put(Store& store, JobId id, JobThread::Completion outcome = {}) {
  return [&store, id, outcome] {
    JobRecord record;
    record.id = id;
    store.put_job(record);
    return outcome;
  };
}

}  // namespace

TEST_CASE("tasks and their completions run one at a time in the order of give()") {
  for (const bool threaded : {false, true}) {
    Room loop(nullptr, threaded);
    std::vector<int> done;      // used by the job thread
    std::vector<int> outcomes;  // used by the loop
    for (int i = 0; i < 500; ++i) {
      loop.give([&, i]() -> JobThread::Completion {
        done.push_back(i);
        return {[&, i] { outcomes.push_back(i); }, {}};
      });
    }
    loop.run_until([&] { return outcomes.size() == 500; });
    CHECK(std::is_sorted(outcomes.begin(), outcomes.end()));
    CHECK(done == outcomes);
  }
}

TEST_CASE("completions run in run_finished() and may queue tasks") {
  for (const bool threaded : {false, true}) {
    Room loop(nullptr, threaded);
    int left = 10;
    std::function<JobThread::Completion()> task = [&]() -> JobThread::Completion {
      return {[&] {
                if (--left > 0) loop.give(task);
              },
              {}};
    };
    loop.give(task);
    CHECK(left == 10);
    loop.run_until([&] { return left == 0; });
  }
}

TEST_CASE("without a store everything counts as committed") {
  Room loop(nullptr, false);
  bool kept = false;
  loop.give([&]() -> JobThread::Completion { return {{}, [&] { kept = true; }}; });
  loop.room.run_finished();
  CHECK(kept);
}

TEST_CASE("`kept` is called only after the commit") {
  for (const bool threaded : {false, true}) {
    CrashStore store(0, 1);
    Room loop(&store, threaded);
    std::size_t kept = 0;
    for (JobId id = 1; id <= 50; ++id) loop.give(put(store, id, {{}, [&] { ++kept; }}));
    loop.run_until([&] { return kept == 50; });
    store.crash();
    CHECK(store.jobs().size() == 50);
  }
}

TEST_CASE("settle() returns when all tasks have run and their data is committed") {
  for (const bool threaded : {false, true}) {
    CAPTURE(threaded);
    CrashStore store(0, 1);
    {
      Room loop(&store, threaded);
      for (JobId id = 1; id <= 50; ++id) loop.give(put(store, id));
      loop.room.settle(seconds(60));
    }
    store.crash();
    CHECK(store.jobs().size() == 50);
  }
}

TEST_CASE("settle() gives up after its time if the disk is full") {
  CrashStore store(0, 1);
  store.fill(true);
  Room loop(&store, true);
  loop.give(put(store, 1));
  loop.room.settle(milliseconds(20));
  loop.run_until([&] { return !loop.room.blocked().empty(); });
}

TEST_CASE("a full disk delays commits, and blocked() says why; commits resume when there is room") {
  CrashStore store(0, 1);
  Room loop(&store, false);
  bool done = false;
  bool kept = false;
  store.fill(true);
  loop.give(put(store, 1, {[&] { done = true; }, [&] { kept = true; }}));
  loop.room.run_finished();
  CHECK(done);
  CHECK_FALSE(kept);
  CHECK(loop.room.blocked().find("disk full") != std::string::npos);
  store.fill(false);
  loop.room.run_finished();
  CHECK(kept);
  CHECK(loop.room.blocked().empty());
}

TEST_CASE("a full disk does not stop tasks in the background thread") {
  CrashStore store(0, 1);
  Room loop(&store, true);
  bool kept = false;
  loop.give([&store]() -> JobThread::Completion {
    store.fill(true);
    return {};
  });
  loop.give(put(store, 1, {{}, [&] { kept = true; }}));
  loop.run_until([&] { return !loop.room.blocked().empty(); });
  CHECK_FALSE(kept);
  loop.give([&store]() -> JobThread::Completion {
    store.fill(false);
    return {};
  });
  loop.run_until([&] { return kept; });
  CHECK(loop.room.blocked().empty());
}

TEST_CASE("if a task throws, its handler gets the error, and the other tasks run") {
  for (const bool threaded : {false, true}) {
    CAPTURE(threaded);
    Room loop(nullptr, threaded);
    std::vector<std::string> whys;
    bool done = false;
    const auto failed = [&](const std::string& why) { whys.push_back(why); };
    loop.room.give([]() -> JobThread::Completion { throw RunError("the file is damaged"); },
                   failed);
    loop.room.give([]() -> JobThread::Completion { throw std::bad_alloc(); }, failed);
    loop.room.give([&]() -> JobThread::Completion { return {[&] { done = true; }, {}}; }, failed);
    loop.run_until([&] { return done; });
    CHECK(whys == std::vector<std::string>{"the file is damaged", "not enough memory"});
  }
}

TEST_CASE("a store that cannot commit ends the loop") {
  class Broken final : public CrashStore {
   public:
    Broken() : CrashStore(0, 1) {}
    void commit() override { throw RunError("the database is damaged"); }
  };
  for (const bool threaded : {false, true}) {
    CAPTURE(threaded);
    Broken store;
    Room loop(&store, threaded);
    const auto give = [&] {
      loop.give(put(store, 1));
      loop.run_until([] { return false; });
    };
    CHECK_THROWS_AS(give(), RunError);
  }
}

TEST_CASE("the destructor waits for the running task and drops the others") {
  std::promise<void> begun;
  std::promise<void> go_on;
  std::atomic<int> done = 0;
  {
    JobThread room(nullptr, {true, {}, milliseconds(1)});
    const auto failed = [](const std::string& why) { FAIL(why); };
    const auto first = [&]() -> JobThread::Completion {
      begun.set_value();
      go_on.get_future().wait();
      ++done;
      return {};
    };
    const auto other = [&]() -> JobThread::Completion {
      ++done;
      return {};
    };
    room.give(first, failed);
    for (int i = 0; i < 100; ++i) room.give(other, failed);
    begun.get_future().wait();
    CHECK(room.backlog() == 101);
    go_on.set_value();
  }
  CHECK(done >= 1);
}

}  // namespace parray
