// Tests a primary and its standby over a connection that loses, repeats, delays and cuts messages,
// while both crash. The standby must have everything acknowledged exactly once.
#include "coordinator/replica/replica.h"

#include <doctest/doctest.h>

#include <array>
#include <limits>
#include <memory>
#include <random>
#include <string>
#include <vector>

#include "common/base/checksum.h"
#include "coordinator/replica/replicated_store.h"
#include "tests/support/crash_store.h"
#include "tests/support/faulty_disk.h"
#include "tests/support/message_of.h"
#include "tests/support/rooms.h"
#include "tests/support/standby_line.h"
#include "tests/support/stored_state.h"
#include "tests/support/temporary_directory.h"

namespace parray::test {
namespace {

/// Returns the content of a store after a crash.
CrashStore kept(const CrashStore& store) {
  CrashStore copy = store;
  copy.crash();
  return copy;
}

void check_same(Store& a, Store& b) {
  const auto jobs = a.jobs();
  const auto others = b.jobs();
  REQUIRE(jobs.size() == others.size());
  for (std::size_t i = 0; i < jobs.size(); ++i) {
    CHECK(record_to_json(jobs[i]) == record_to_json(others[i]));
    CHECK(rows_of(a, jobs[i].id) == rows_of(b, jobs[i].id));
    CHECK(a.picture(jobs[i].id) == b.picture(jobs[i].id));
    if (needs_scene(jobs[i].state, jobs[i].keeps_scene())) {
      CHECK(a.scene(jobs[i].scene) == b.scene(jobs[i].scene));
    }
  }
  CHECK(a.note("workers") == b.note("workers"));
}

/// Makes random changes. Job 1 only gets numbered results appended; other jobs are added and
/// dropped.
class Work {
 public:
  explicit Work(std::uint64_t seed) : random_(seed) {}

  void do_something(Store& store, std::uint64_t rows) {
    const JobId other = 2 + random_() % 3;
    switch (random_() % 7) {
      case 0:
        store.put_scene(digest('b'), "scene b");
        store.put_job(stored_job(other, JobState::queued, 'b'));
        break;
      case 1: store.drop_job(other); break;
      case 2:
        store.put_job(stored_job(other, JobState::done));
        put_picture(store, other, "picture " + std::to_string(random_()));
        store.drop_work(other);
        break;
      case 3: store.put_note("workers", std::to_string(random_())); break;
      default: store.append_rows(1, std::to_string(rows));
    }
  }

 private:
  std::mt19937_64 random_;
};

bool commits(Store& store) {
  try {
    store.commit();
    return true;
  } catch (const StorageFull&) {
    return false;
  }
}

std::unique_ptr<ReplicatedStore> started(CrashStore& store, Standby& standby,
                                         const std::function<std::uint64_t()>& random) {
  for (;;) {
    try {
      return std::make_unique<ReplicatedStore>(store, standby, random);
    } catch (const StorageFull&) {
      store.crash();  // the primary restarts
    }
  }
}

/// Simulates both with all kinds of failures. Returns whether they end in step.
bool live(std::uint64_t seed) {
  std::mt19937_64 random(seed);
  CrashStore first(0.05, seed);
  CrashStore second(0.05, seed + 1);
  Standby standby(second, 0.1, seed);
  const auto next_number = numbers(seed);
  auto primary = started(first, standby, next_number);
  primary->put_scene(digest('a'), "scene a");
  primary->put_job(stored_job(1));
  Work work(seed);
  std::size_t acknowledged = 0;
  for (int step = 0; step < 60; ++step) {
    if (primary->jobs().empty()) {  // the primary crashed before its first commit
      primary->put_scene(digest('a'), "scene a");
      primary->put_job(stored_job(1));
    }
    work.do_something(*primary, rows_of(*primary, 1).size());
    if (random() % 2 == 0 && commits(*primary)) {
      acknowledged = rows_of(*primary, 1).size();
      CrashStore a = kept(first);
      CrashStore b = kept(second);
      check_same(a, b);
    }
    if (random() % 15 == 0) {
      second.crash();
      standby.restart();
    }
    if (random() % 15 == 0) {
      first.crash();
      primary = started(first, standby, next_number);
    }
    CHECK(first.committed_rows(1).size() >= acknowledged);
    if (standby.replica().in_step()) {
      const std::vector<std::string> rows = kept(second).committed_rows(1);
      CHECK(rows.size() >= acknowledged);
      for (std::size_t i = 0; i < rows.size(); ++i) CHECK(rows[i] == std::to_string(i));
    }
  }
  const bool in_step = standby.replica().in_step();
  // Without failures, the two become equal again.
  standby.heal();
  second.fill(false);
  bool committed = false;
  for (int i = 0; i < 20 && !committed; ++i) committed = commits(*primary);
  CHECK(committed);
  check_same(first, second);
  return in_step;
}

}  // namespace

TEST_CASE(
    "the standby has everything acknowledged exactly once, despite lost messages and crashes") {
  int in_step = 0;
  constexpr int lives = 200;
  for (std::uint64_t seed = 0; seed < lives; ++seed) {
    CAPTURE(seed);
    in_step += live(seed) ? 1 : 0;
  }
  CHECK(in_step > lives / 2);
}

TEST_CASE(
    "a primary commits nothing while its standby does not answer, and everything afterwards") {
  CrashStore first(0, 1);
  CrashStore second(0, 2);
  Standby standby(second);
  ReplicatedStore primary(first, standby, numbers(1));
  primary.put_job(stored_job(1));
  primary.commit();
  standby.cut_off = true;
  primary.append_rows(1, "row");
  CHECK_THROWS_WITH_AS(
      primary.commit(),
      "the standby at tcp://standby:7401 does not answer: jobs wait until the standby stores the "
      "primary's changes again",
      StorageFull);
  CHECK(first.committed_rows(1).empty());
  standby.cut_off = false;
  primary.append_rows(1, "another");
  primary.commit();
  CHECK(first.committed_rows(1).size() == 2);
  CHECK(second.committed_rows(1) == first.committed_rows(1));
}

TEST_CASE("changes that wait for a standby survive a full copy to another standby at its address") {
  for (int answered = 0; answered < 4; ++answered) {  // hello, copy, piece, commit
    for (const bool under_way : {false, true}) {      // the batch was sent, or not yet
      CAPTURE(answered);
      CAPTURE(under_way);
      CrashStore first(0, 1);
      CrashStore second(0, 2);
      CrashStore third(0, 3);
      Standby standby(second);
      ReplicatedStore primary(first, standby, numbers(1));
      primary.put_job(stored_job(1));
      primary.commit();
      standby.cut_off = under_way;
      primary.append_rows(1, "row");
      CHECK(commits(primary) == !under_way);
      if (!under_way) primary.append_rows(1, "another");
      standby.become(third);
      standby.cut_off = false;
      standby.last_call = standby.calls + answered;
      CHECK_FALSE(commits(primary));
      standby.become(second);
      standby.cut_off = false;
      standby.last_call = std::numeric_limits<int>::max();
      CHECK(commits(primary));
      CHECK(second.committed_rows(1) == first.committed_rows(1));
      CHECK(first.committed_rows(1).size() == (under_way ? 1 : 2));
    }
  }
}

TEST_CASE("a restarted standby gets no full copy, a new one does") {
  CrashStore first(0, 1);
  CrashStore second(0, 2);
  Standby standby(second);
  ReplicatedStore primary(first, standby, numbers(1));
  primary.put_job(stored_job(1));
  for (int i = 0; i < 100; ++i) primary.append_rows(1, std::string(1 << 20, 'x'));
  primary.commit();
  standby.restart();
  standby.calls = 0;
  primary.commit();
  CHECK(standby.calls == 1);  // hello
  CHECK(standby.replica().in_step());
  CrashStore third(0, 3);
  Standby other(third);
  ReplicatedStore again(first, other, numbers(2));
  again.commit();
  CHECK(other.calls > 100 / 4);  // in pieces of 4 MiB
  check_same(first, third);
}

TEST_CASE("a standby that has taken over fences its primary, also after a restart") {
  CrashStore first(0, 1);
  CrashStore second(0, 2);
  Standby standby(second);
  ReplicatedStore primary(first, standby, numbers(1));
  primary.put_job(stored_job(1));
  primary.commit();
  CHECK(serve_alone(second) == 2);
  standby.restart();
  CHECK(standby.replica().has_taken_over());
  primary.append_rows(1, "row");
  CHECK_THROWS_WITH_AS(
      primary.commit(),
      "fenced: the standby at tcp://standby:7401 has taken over and serves instead "
      "of this primary (generation 2 of the farm's state instead of 1): start "
      "this coordinator with --standby, and the other one with --replicate-to",
      RunError);
  CHECK(first.committed_rows(1).empty());
  ReplicatedStore restarted(first, standby, numbers(2));
  CHECK_THROWS_AS(restarted.commit(), RunError);
}

TEST_CASE("the old primary becomes the standby of the coordinator that took over") {
  CrashStore first(0, 1);
  CrashStore second(0, 2);
  {
    Standby standby(second);
    ReplicatedStore primary(first, standby, numbers(1));
    primary.put_job(stored_job(1));
    primary.commit();
  }
  serve_alone(second);
  CHECK(second.mark().empty());
  second.append_rows(1, "after the takeover");
  second.commit();
  Standby standby(first);
  ReplicatedStore primary(second, standby, numbers(2));
  primary.commit();
  CHECK(standby.replica().in_step());
  check_same(first, second);
  CHECK(serve_alone(first) == 4);
}

TEST_CASE("a standby with another farm's state or with jobs of its own refuses a primary") {
  CrashStore first(0, 1);
  CrashStore second(0, 2);
  CrashStore stranger(0, 3);
  Standby standby(second);
  ReplicatedStore primary(first, standby, numbers(1));
  primary.put_job(stored_job(1));
  primary.commit();
  ReplicatedStore other(stranger, standby, numbers(2));
  CHECK_THROWS_AS(other.commit(), RunError);
  CHECK(second.jobs().size() == 1);
  stranger.put_job(stored_job(7));
  stranger.put_note(replication_note, "");
  CHECK_THROWS_AS(Replica{stranger}, InputError);
}

TEST_CASE("a primary that was set back overwrites its standby only with --overwrite") {
  CrashStore first(0, 1);
  CrashStore second(0, 2);
  Standby standby(second);
  ReplicatedStore primary(first, standby, numbers(1));
  primary.put_job(stored_job(1));
  primary.commit();
  const CrashStore snapshot = kept(first);
  for (JobId id = 2; id <= 4; ++id) {
    primary.put_job(stored_job(id));
    primary.commit();
  }
  const auto refusal = [&](CrashStore store, bool alone_meanwhile) {
    if (alone_meanwhile) serve_alone(store);
    ReplicatedStore set_back(store, standby, numbers(2));
    const std::string message = message_of<RunError>([&] { set_back.commit(); });
    CHECK(kept(second).jobs().size() == 4);
    return message;
  };
  const std::string expected =
      "the standby at tcp://standby:7401 refuses this primary: the state of the primary is older "
      "than that of the standby, and 3 batches of changes would be lost: serve the standby's "
      "state, or start the standby with --overwrite";
  CHECK(refusal(snapshot, false) == expected);
  CHECK(refusal(snapshot, true) == expected);
  primary.put_job(stored_job(5));
  primary.commit();  // the real primary continues
  CHECK(kept(second).jobs().size() == 5);
  standby.overwrite = true;
  standby.restart();
  CrashStore store = snapshot;
  ReplicatedStore set_back(store, standby, numbers(3));
  set_back.commit();
  CHECK(kept(second).jobs().size() == 1);
}

TEST_CASE("a primary that served without its standby accepts the standby again") {
  CrashStore first(0, 1);
  CrashStore second(0, 2);
  Standby standby(second);
  {
    ReplicatedStore primary(first, standby, numbers(1));
    for (JobId id = 1; id <= 4; ++id) {
      primary.put_job(stored_job(id));
      primary.commit();
    }
  }
  serve_alone(first);
  first.put_job(stored_job(5));
  first.commit();
  ReplicatedStore primary(first, standby, numbers(2));
  primary.commit();
  check_same(first, second);
}

TEST_CASE("a fenced primary serves again only with --serve-fenced, as another farm") {
  CrashStore store(0, 1);
  put_replication_state(store, {7, 3, ReplicaRole::primary});
  store.commit();
  check_fence(store, false, 9);
  note_fence(store);
  CHECK_THROWS_WITH_AS(check_fence(store, false, 9), doctest::Contains("--serve-fenced"),
                       InputError);
  CHECK(replication_state_of(store)->history == 7);
  check_fence(store, true, 9);
  CHECK(replication_state_of(store)->history == 9);
  check_fence(store, false, 11);
  CHECK(serve_alone(store) == 2);
}

TEST_CASE("a repeated batch is answered and not applied again") {
  CrashStore second(0, 2);
  Replica replica(second);
  const Position begin{1, 1, 0};
  const Position end{1, 1, 1};
  Changes changes;
  changes.put_job(stored_job(1));
  changes.append_rows(1, "row");
  const std::string batch = changes.take();
  const auto answer = [&](const ReplicaRequest& request) {
    return decode_reply(replica.answer(encode(request))).kind;
  };
  CHECK(answer({9, 1, ReplicaRequestKind::begin_session, begin}) == ReplicaReplyKind::behind);
  CHECK(answer({9, 2, ReplicaRequestKind::copy, begin}) == ReplicaReplyKind::done);
  const ReplicaRequest piece{9, 3, ReplicaRequestKind::piece, end, 0, 0, false, batch};
  const ReplicaRequest commit{
      9, 4, ReplicaRequestKind::commit, end, batch.size(), checksum_of(batch), true};
  for (int i = 0; i < 3; ++i) {
    CHECK(answer(piece) == ReplicaReplyKind::received);
    CHECK(answer(piece) == ReplicaReplyKind::received);
    CHECK(answer(commit) == ReplicaReplyKind::committed);
    CHECK(answer({9, 2, ReplicaRequestKind::copy, begin}) == ReplicaReplyKind::done);  // late
  }
  CHECK(second.committed_rows(1) == std::vector<std::string>{"row"});
  CHECK(replica.in_step());
}

TEST_CASE("an incomplete copy cannot serve") {
  CrashStore second(0, 2);
  Replica replica(second);
  const Position position{1, 1, 5};
  replica.answer(encode(ReplicaRequest{9, 1, ReplicaRequestKind::begin_session, position}));
  replica.answer(encode(ReplicaRequest{9, 2, ReplicaRequestKind::copy, position}));
  CHECK_FALSE(replica.in_step());
  CHECK_THROWS_AS(serve_alone(second), InputError);
}

TEST_CASE("a standby without room reports that, and commits the batch when there is room") {
  CrashStore first(0, 1);
  CrashStore second(0, 2);
  Standby standby(second);
  ReplicatedStore primary(first, standby, numbers(1));
  primary.put_job(stored_job(1));
  primary.commit();
  second.fill(true);
  primary.append_rows(1, "row");
  primary.put_scene(digest('a'), "scene a");  // fails in the middle of the batch
  primary.append_rows(1, "another");
  for (int i = 0; i < 3; ++i) CHECK_THROWS_AS(primary.commit(), StorageFull);
  second.fill(false);
  primary.commit();
  check_same(first, second);
}

TEST_CASE("changes that a full standby refused and its primary lost are in neither store") {
  CrashStore first(0, 1);
  CrashStore second(0, 2);
  Standby standby(second);
  {
    ReplicatedStore primary(first, standby, numbers(1));
    primary.put_job(stored_job(1));
    primary.commit();
    second.fill(true);
    primary.append_rows(1, "lost");
    CHECK_THROWS_AS(primary.commit(), StorageFull);
  }
  first.crash();
  second.fill(false);
  ReplicatedStore primary(first, standby, numbers(2));
  primary.append_rows(1, "row");
  primary.commit();
  CHECK(second.committed_rows(1) == std::vector<std::string>{"row"});
  check_same(first, second);
}

TEST_CASE("a message that is cut or changed anywhere is refused") {
  const std::string request =
      encode(ReplicaRequest{1, 2, ReplicaRequestKind::piece, {3, 4, 5}, 6, 7, true, "bytes"});
  const std::string answer = encode(ReplicaReply{1, 2, ReplicaReplyKind::full, 3, "text"});
  for (const std::string& message : {request, answer}) {
    for (std::size_t i = 0; i < message.size(); ++i) {
      std::string changed = message;
      changed[i] = static_cast<char>(changed[i] ^ 1);
      for (const std::string& bad : {message.substr(0, i), changed}) {
        CHECK_THROWS_AS(decode_request(bad), DecodeError);
        CHECK_THROWS_AS(decode_reply(bad), DecodeError);
      }
    }
  }
  CHECK(decode_request(request).bytes == "bytes");
  CHECK(decode_reply(answer).text == "text");
  CHECK_THROWS_AS(decode_request(answer), DecodeError);
}

TEST_CASE("a commit that holds back a job, or has no mark of its own, leaves no mark") {
  const TemporaryDirectory directory(in_memory());
  FaultyDisk disk;
  {
    DiskStore store(directory.path(), disk);
    store.put_job(stored_job(1));
    store.put_mark("first");
    store.commit();
    CHECK(store.mark() == "first");
    store.append_rows(1, std::string(1000, 'x'));
    store.put_job(stored_job(2));
    store.put_mark("second");
    disk.failing_syncs = 1;  // that of the rows
    CHECK_THROWS_AS(store.commit(), StorageFull);
  }
  DiskStore store(directory.path(), disk);
  CHECK(store.jobs().size() == 2);  // the other job was kept
  CHECK(store.mark().empty());
  store.put_mark("third");
  store.commit();
  CHECK(store.mark() == "third");
  store.put_job(stored_job(3));
  store.commit();
  CHECK(store.mark().empty());
  CHECK(store.notes().empty());
}

}  // namespace parray::test
