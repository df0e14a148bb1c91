// A primary and its standby over a line that loses, repeats, delays and cuts what travels on it,
// while either crashes: whatever was acknowledged is in the standby, once.
#include "coordinator/replica/replica.h"

#include <doctest/doctest.h>

#include <array>
#include <limits>
#include <memory>
#include <random>
#include <string>
#include <vector>

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

/// What a store would have after a crash.
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
    if (needs_scene(jobs[i].state)) {
      CHECK(a.scene(jobs[i].scene) == b.scene(jobs[i].scene));
    }
  }
  CHECK(a.note("workers") == b.note("workers"));
}

/// Work of a coordinator's: job 1 has rows appended only, numbered; others come and go.
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
      case 1:
        store.drop_job(other);
        break;
      case 2:
        store.put_job(stored_job(other, JobState::done));
        put_picture(store, other, "picture " + std::to_string(random_()));
        store.drop_work(other);
        break;
      case 3:
        store.put_note("workers", std::to_string(random_()));
        break;
      default:
        store.append_rows(1, std::to_string(rows));
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
      store.crash();  // it is started again
    }
  }
}

/// A life of both with everything that may happen to them. Returns whether it ended in step.
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
    if (primary->jobs().empty()) {  // it has crashed before its first commit
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
      for (std::size_t i = 0; i < rows.size(); ++i) {
        CHECK(rows[i] == std::to_string(i));
      }
    }
  }
  const bool in_step = standby.replica().in_step();
  // Once all is well the two are soon the same again.
  standby.heal();
  second.fill(false);
  bool committed = false;
  for (int i = 0; i < 20 && !committed; ++i) {
    committed = commits(*primary);
  }
  CHECK(committed);
  check_same(first, second);
  return in_step;
}

}  // namespace

TEST_CASE(
    "whatever was acknowledged is in the standby, once, whatever is lost and whoever crashes") {
  int in_step = 0;
  constexpr int lives = 200;
  for (std::uint64_t seed = 0; seed < lives; ++seed) {
    CAPTURE(seed);
    in_step += live(seed) ? 1 : 0;
  }
  CHECK(in_step > lives / 2);
}

TEST_CASE("nothing is committed while the standby does not answer, and all of it once it does") {
  CrashStore first(0, 1);
  CrashStore second(0, 2);
  Standby standby(second);
  ReplicatedStore primary(first, standby, numbers(1));
  primary.put_job(stored_job(1));
  primary.commit();
  standby.cut_off = true;
  primary.append_rows(1, "row");
  CHECK_THROWS_WITH_AS(primary.commit(),
                       "the standby at tcp://standby:7401 does not answer: nothing is acknowledged "
                       "until it does",
                       StorageFull);
  CHECK(first.committed_rows(1).empty());
  standby.cut_off = false;
  primary.append_rows(1, "another");
  primary.commit();
  CHECK(first.committed_rows(1).size() == 2);
  CHECK(second.committed_rows(1) == first.committed_rows(1));
}

TEST_CASE("what waits for a standby is not lost while another one, in its place, gets a copy") {
  for (int answered = 0; answered < 4; ++answered) {  // hello, copy, piece, commit
    for (const bool under_way : {false, true}) {      // it may have been sent, or not yet
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
      if (!under_way) {
        primary.append_rows(1, "another");
      }
      standby.become(third);
      standby.cut_off = false;
      standby.last_ask = standby.asks + answered;
      CHECK_FALSE(commits(primary));
      standby.become(second);
      standby.cut_off = false;
      standby.last_ask = std::numeric_limits<int>::max();
      CHECK(commits(primary));
      CHECK(second.committed_rows(1) == first.committed_rows(1));
      CHECK(first.committed_rows(1).size() == (under_way ? 1 : 2));
    }
  }
}

TEST_CASE("a standby that goes on from where it was gets no full copy, one that is new does") {
  CrashStore first(0, 1);
  CrashStore second(0, 2);
  Standby standby(second);
  ReplicatedStore primary(first, standby, numbers(1));
  primary.put_job(stored_job(1));
  for (int i = 0; i < 100; ++i) {
    primary.append_rows(1, std::string(1 << 20, 'x'));
  }
  primary.commit();
  standby.restart();
  standby.asks = 0;
  primary.commit();
  CHECK(standby.asks == 1);  // hello
  CHECK(standby.replica().in_step());
  CrashStore third(0, 3);
  Standby other(third);
  ReplicatedStore again(first, other, numbers(2));
  again.commit();
  CHECK(other.asks > 100 / 4);  // in pieces of 4 MiB
  check_same(first, third);
}

TEST_CASE("once it has taken over, a standby fences its primary, and goes on after a restart") {
  CrashStore first(0, 1);
  CrashStore second(0, 2);
  Standby standby(second);
  ReplicatedStore primary(first, standby, numbers(1));
  primary.put_job(stored_job(1));
  primary.commit();
  CHECK(serve_alone(second) == 2);
  standby.restart();
  CHECK(standby.replica().serves());
  primary.append_rows(1, "row");
  CHECK_THROWS_WITH_AS(primary.commit(),
                       "fenced: the standby at tcp://standby:7401 serves as generation 2, this one "
                       "was generation 1",
                       RunError);
  CHECK(first.committed_rows(1).empty());
  ReplicatedStore restarted(first, standby, numbers(2));
  CHECK_THROWS_AS(restarted.commit(), RunError);
}

TEST_CASE("the old primary becomes the standby of the one that took over") {
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

TEST_CASE(
    "a standby with another farm's state, or with jobs of its own, refuses to be overwritten") {
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

TEST_CASE(
    "a primary that was set back does not overwrite its standby, unless that is told to let it") {
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
    if (alone_meanwhile) {
      serve_alone(store);
    }
    ReplicatedStore set_back(store, standby, numbers(2));
    const std::string message = message_of<RunError>([&] { set_back.commit(); });
    CHECK(kept(second).jobs().size() == 4);
    return message;
  };
  const std::string expected =
      "the standby at tcp://standby:7401 refuses to be one: the primary has been set back: 3 "
      "batches would be lost: serve from the standby, or start it with --overwrite";
  CHECK(refusal(snapshot, false) == expected);
  CHECK(refusal(snapshot, true) == expected);
  primary.put_job(stored_job(5));
  primary.commit();  // the true one goes on
  CHECK(kept(second).jobs().size() == 5);
  standby.overwrite = true;
  standby.restart();
  CrashStore store = snapshot;
  ReplicatedStore set_back(store, standby, numbers(3));
  set_back.commit();
  CHECK(kept(second).jobs().size() == 1);
}

TEST_CASE("a primary whose standby was away takes it in again, whatever it has done alone") {
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

TEST_CASE("a fenced primary serves again only when it is told to, and as another farm") {
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

TEST_CASE("a batch that comes again is answered and not applied again") {
  CrashStore second(0, 2);
  Replica replica(second);
  const Position begin{1, 1, 0};
  const Position end{1, 1, 1};
  Changes changes;
  changes.put_job(stored_job(1));
  changes.append_rows(1, "row");
  const std::string batch = changes.take();
  const auto answer = [&](const ReplicaRequest& ask) {
    return decode_reply(replica.answer(encode(ask))).kind;
  };
  CHECK(answer({9, 1, ReplicaRequestKind::hello, begin}) == ReplicaReplyKind::behind);
  CHECK(answer({9, 2, ReplicaRequestKind::copy, begin}) == ReplicaReplyKind::well);
  const ReplicaRequest piece{9, 3, ReplicaRequestKind::piece, end, 0, 0, false, batch};
  const ReplicaRequest commit{
      9, 4, ReplicaRequestKind::commit, end, batch.size(), checksum_of(batch), true};
  for (int i = 0; i < 3; ++i) {
    CHECK(answer(piece) == ReplicaReplyKind::have);
    CHECK(answer(piece) == ReplicaReplyKind::have);
    CHECK(answer(commit) == ReplicaReplyKind::committed);
    CHECK(answer({9, 2, ReplicaRequestKind::copy, begin}) == ReplicaReplyKind::well);  // late
  }
  CHECK(second.committed_rows(1) == std::vector<std::string>{"row"});
  CHECK(replica.in_step());
}

TEST_CASE("a copy that is not whole serves nobody") {
  CrashStore second(0, 2);
  Replica replica(second);
  const Position position{1, 1, 5};
  replica.answer(encode(ReplicaRequest{9, 1, ReplicaRequestKind::hello, position}));
  replica.answer(encode(ReplicaRequest{9, 2, ReplicaRequestKind::copy, position}));
  CHECK_FALSE(replica.in_step());
  CHECK_THROWS_AS(serve_alone(second), InputError);
}

TEST_CASE("a standby without room says so, and takes the batch when there is some") {
  CrashStore first(0, 1);
  CrashStore second(0, 2);
  Standby standby(second);
  ReplicatedStore primary(first, standby, numbers(1));
  primary.put_job(stored_job(1));
  primary.commit();
  second.fill(true);
  primary.append_rows(1, "row");
  primary.put_scene(digest('a'), "scene a");  // finds no room in the midst of the batch
  primary.append_rows(1, "another");
  for (int i = 0; i < 3; ++i) {
    CHECK_THROWS_AS(primary.commit(), StorageFull);
  }
  second.fill(false);
  primary.commit();
  check_same(first, second);
}

TEST_CASE("what a standby had no room for, and its primary has lost, is in neither") {
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

TEST_CASE("no damaged message is taken for one, wherever it is cut or changed") {
  const std::string ask =
      encode(ReplicaRequest{1, 2, ReplicaRequestKind::piece, {3, 4, 5}, 6, 7, true, "bytes"});
  const std::string answer = encode(ReplicaReply{1, 2, ReplicaReplyKind::full, 3, "text"});
  for (const std::string& message : {ask, answer}) {
    for (std::size_t i = 0; i < message.size(); ++i) {
      std::string changed = message;
      changed[i] = static_cast<char>(changed[i] ^ 1);
      for (const std::string& bad : {message.substr(0, i), changed}) {
        CHECK_THROWS_AS(decode_request(bad), DecodeError);
        CHECK_THROWS_AS(decode_reply(bad), DecodeError);
      }
    }
  }
  CHECK(decode_request(ask).bytes == "bytes");
  CHECK(decode_reply(answer).text == "text");
  CHECK_THROWS_AS(decode_request(answer), DecodeError);
}

TEST_CASE("a commit that keeps a part, or that has no mark of its own, leaves none") {
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
