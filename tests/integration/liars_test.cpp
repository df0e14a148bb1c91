// Results are believed from holders only, and only as long as nobody contradicts them.
#include <doctest/doctest.h>

#include <algorithm>

#include "tests/support/crash_store.h"
#include "tests/support/service.h"

namespace parray::test {
namespace {

bool contains(const std::string& text, const std::string& part) {
  return text.find(part) != std::string::npos;
}

CoordinatorOptions with_checks(double share) {
  CoordinatorOptions options = service_options();
  options.spot_checks = share;
  return options;
}

void check_mended(Service& service, JobId job, const RenderSettings& settings) {
  REQUIRE(service.state(job) == "done");
  CHECK(service.sha256(job) == (settings.in_passes()
                                    ? reference_passes_sha256(small_scene(), settings)
                                    : reference_sha256(small_scene(), settings)));
  const auto report = service.fetch(job).report;
  CHECK(report.at("image_sha256") == service.sha256(job));
  CHECK(contains(report.at("flag"), "'liar'"));
  CHECK(contains(service.job(job).at("flag"), "'liar'"));
  CHECK(service.worker("liar").at("state") == "quarantined");
  CHECK(service.worker("liar").at("leases") == 0);
}

RenderSettings in_passes() {
  RenderSettings settings = many_leases();
  const std::uint64_t pixels = std::uint64_t{settings.width} * settings.height;
  settings.adaptive = true;
  settings.passes = {4 * pixels, 3 * pixels, 2 * pixels};
  return settings;
}

}  // namespace

TEST_CASE("a result for somebody else's lease is stale, before and after its holder's") {
  Service service;
  Hand ann(service, "ann");
  const JobId job = service.submit(small_scene(), many_leases());
  service.turn();
  ann.listen();
  const msg::Grant grant = ann.held.begin()->second;
  Hand thief(service, "thief");
  thief.send_lie(grant);
  service.turn();
  thief.listen();
  CHECK(thief.verdicts == std::vector<msg::Verdict>{msg::Verdict::stale});
  ann.send_honest(ann.put_down());
  service.turn();
  ann.listen();
  CHECK(ann.verdicts == std::vector<msg::Verdict>{msg::Verdict::accepted});
  thief.send_lie(grant);
  work(service, {{&ann, honest}, {&thief, honest}}, job);
  CHECK(service.sha256(job) == reference_sha256(small_scene(), many_leases()));
  CHECK(service.job(job).at("flag") == "");
  CHECK(service.worker("ann").at("state") == "ready");
}

TEST_CASE(
    "a result for an earlier coordinator, of which nothing was kept, is stale and convicts "
    "nobody") {
  Service service;
  Hand ann(service, "ann");
  RenderSettings others = many_leases();
  others.width += 5;
  service.submit(small_scene(), others);
  service.turn();
  ann.listen();
  const msg::Grant old = ann.put_down();
  service.restart();
  Hand again(service, "ann");  // the same process: its name and instance
  const JobId job = service.submit(small_scene(), many_leases());
  REQUIRE(job == old.job);
  service.turn();
  again.listen();
  REQUIRE_FALSE(again.held.empty());
  again.send_honest(old);
  service.turn();
  again.listen();
  CHECK(again.verdicts == std::vector<msg::Verdict>{msg::Verdict::stale});
  work(service, {{&again, honest}}, job);
  CHECK(service.sha256(job) == reference_sha256(small_scene(), many_leases()));
}

TEST_CASE("sums that nothing can have given convict who sends them, and are not merged") {
  Service service;
  Hand liar(service, "liar");
  const JobId job = service.submit(small_scene(), many_leases());
  service.turn();
  liar.listen();
  const msg::Grant grant = liar.put_down();
  TracedCells cells = Hand::trace(small_scene(), grant);
  cells.records[sizeof(CellHeader) + 7] = std::byte{0x80};  // 2^63
  liar.say(Hand::result(grant, std::move(cells)));
  service.turn();
  CHECK(service.worker("liar").at("state") == "quarantined");
  CHECK(contains(service.worker("liar").at("reason"), "sums"));
  CHECK(service.job(job).at("progress") == 0);
  CHECK(service.job(job).at("waits_for") == "no worker whose results can be trusted");
  Hand ann(service, "ann");
  work(service, {{&ann, honest}, {&liar, lying}}, job);
  CHECK(service.sha256(job) == reference_sha256(small_scene(), many_leases()));
}

TEST_CASE("a result that was damaged on its way convicts nobody: its cells are traced again") {
  Service service;
  Hand ann(service, "ann");
  const JobId job = service.submit(small_scene(), many_leases());
  service.turn();
  ann.listen();
  const msg::Grant grant = ann.put_down();
  Frames frames = encode(Hand::result(grant, Hand::trace(small_scene(), grant)));
  std::string bulk(frames[1].view());
  bulk.back() = static_cast<char>(bulk.back() ^ 1);
  frames[1] = std::move(bulk);
  service.say_frames(ann.peer(), frames);
  service.turn();
  CHECK(service.worker("ann").at("state") == "ready");
  work(service, {{&ann, honest}}, job);
  CHECK(service.sha256(job) == reference_sha256(small_scene(), many_leases()));
}

TEST_CASE("of two that differ a third decides, whoever came first; what the liar did is undone") {
  for (const bool liar_first : {true, false}) {
    CAPTURE(liar_first);
    Service service(with_checks(1));
    Hand ann(service, liar_first ? "liar" : "ann");
    RenderSettings settings = many_leases();
    settings.height = 200;
    const JobId job = service.submit(small_scene(), settings);
    work(service, {{&ann, liar_first ? lying : honest}}, job, 3);  // alone: nobody checks
    Hand bob(service, liar_first ? "ann" : "liar");
    const Hands two{{&ann, liar_first ? lying : honest}, {&bob, liar_first ? honest : lying}};
    work(service, two, job, 20);
    CHECK(service.tally().mismatch > 0);
    CHECK(service.state(job) == "paused");
    CHECK(contains(service.job(job).at("reason"), "start one more worker"));
    CHECK(contains(service.job(job).at("reason"), "'liar'"));
    CHECK(contains(service.job(job).at("reason"), "'ann'"));
    CHECK(service.worker("ann").at("state") == "ready");  // nothing is decided
    Hand cid(service, "cid");
    Hands three = two;
    three.emplace_back(&cid, honest);
    work(service, three, job);
    CHECK(service.worker("ann").at("state") == "ready");
    CHECK(service.worker("cid").at("state") == "ready");
    check_mended(service, job, settings);
  }
}

/// `ann` does everything but what the slow one and the liar hold, which do nothing, until it holds
/// a copy of the liar's lease, which is returned.
static msg::Grant work_until_copied(Service& service, Hand& slow, Hand& ann, Hand& liar) {
  std::optional<msg::Grant> lies;
  for (int round = 0; round < 200; ++round) {
    service.turn();
    for (Hand* hand : {&slow, &ann, &liar}) {
      hand->listen();
      hand->beat();
    }
    if (!liar.held.empty() && !lies) {
      lies = liar.held.begin()->second;
    }
    if (!ann.held.empty() && lies && ann.held.begin()->first.second == lies->epoch) {
      return *lies;
    }
    if (!ann.held.empty()) {
      ann.send_honest(ann.put_down());
    }
  }
  FAIL("no copy was made");
  return {};
}

TEST_CASE("the copies near the end are compared, too") {
  for (const bool liar_first : {true, false}) {
    CAPTURE(liar_first);
    Service service;
    Hand slow(service, "slow", 1);
    Hand ann(service, "ann");
    Hand liar(service, "liar");
    const JobId job = service.submit(small_scene(), many_leases());
    service.turn();
    const msg::Grant lies = work_until_copied(service, slow, ann, liar);
    const msg::Grant copy = ann.put_down();
    if (liar_first) {
      liar.send_lie(lies);
      service.turn();
      ann.send_honest(copy);
    } else {
      ann.send_honest(copy);
      service.turn();
      liar.send_lie(lies);
    }
    service.turn();
    CHECK(service.tally().mismatch == 1);
    Hand cid(service, "cid");
    work(service, {{&ann, honest}, {&slow, honest}, {&liar, idle}, {&cid, honest}}, job);
    check_mended(service, job, many_leases());
  }
}

TEST_CASE("a liar that is asked twice about the same samples is one voice, not two") {
  Service service(with_checks(1));
  Hand slow(service, "slow", 1);
  Hand ann(service, "ann");
  Hand liar(service, "liar");
  const JobId job = service.submit(small_scene(), many_leases());
  service.turn();
  const msg::Grant late = work_until_copied(service, slow, ann, liar);
  ann.send_honest(ann.put_down());
  // Its own result of the lease comes late; then it gets the spot check of the same cells.
  liar.held.erase({late.job, late.epoch});
  liar.send_lie(late);
  work(service, {{&ann, honest}, {&liar, lying}}, job, 60);  // the slow one is lost
  CHECK(service.tally().mismatch > 0);
  CHECK(service.worker("ann").at("state") == "ready");
  Hand bob(service, "bob");
  Hand cid(service, "cid");
  work(service, {{&ann, honest}, {&liar, lying}, {&bob, honest}, {&cid, honest}}, job);
  CHECK(service.worker("ann").at("state") == "ready");
  check_mended(service, job, many_leases());
}

TEST_CASE("spot checks find a liar in the middle of a job, and all that it has done is undone") {
  for (const double share : {0.25, 0.5, 1.0}) {
    CAPTURE(share);
    Service service(with_checks(share));
    Hand ann(service, "ann");
    Hand bob(service, "bob");
    Hand liar(service, "liar");
    RenderSettings settings = many_leases();
    settings.height = 600;
    const JobId job = service.submit(small_scene(), settings);
    work(service, {{&ann, honest}, {&bob, honest}, {&liar, honest}}, job, 1);
    work(service, {{&ann, honest}, {&bob, honest}, {&liar, lying}}, job);
    check_mended(service, job, settings);
    CHECK(service.worker("ann").at("state") == "ready");
    CHECK(service.worker("bob").at("state") == "ready");
    CHECK(service.worker("liar").at("accepted") > 0);
  }
}

TEST_CASE("spot checks of honest workers cost time and nothing else") {
  Service service(with_checks(1));
  Hand ann(service, "ann");
  Hand bob(service, "bob");
  const JobId job = service.submit(small_scene(), many_leases());
  work(service, {{&ann, honest}, {&bob, honest}}, job);
  CHECK(service.tally().duplicate > 0);
  CHECK(service.tally().mismatch == 0);
  CHECK(service.job(job).at("flag") == "");
  CHECK(service.sha256(job) == reference_sha256(small_scene(), many_leases()));
}

TEST_CASE("a job says how many checks could not be made, for want of a second worker") {
  Service service(with_checks(1));
  Hand ann(service, "ann");
  const JobId job = service.submit(small_scene(), many_leases());
  work(service, {{&ann, honest}}, job);
  REQUIRE(service.state(job) == "done");
  CHECK(contains(service.job(job).at("flag"), "were to be checked by a second worker"));
  CHECK(contains(service.fetch(job).report.at("flag"), "second worker"));
}

TEST_CASE("a picture in passes that a liar has touched is begun again, and is the honest one") {
  Service service(with_checks(1));
  Hand ann(service, "ann");
  Hand bob(service, "bob");
  Hand liar(service, "liar");
  const JobId job = service.submit(small_scene(), in_passes());
  work(service, {{&ann, honest}, {&bob, honest}, {&liar, honest}}, job, 12);
  work(service, {{&ann, honest}, {&bob, honest}, {&liar, lying}}, job);
  check_mended(service, job, in_passes());
  CHECK(service.fetch(job).report.at("passes") == in_passes().passes);
}

TEST_CASE("what was undone stays so when the coordinator dies at any moment afterwards") {
  for (const bool passes : {false, true}) {
    RenderSettings settings = passes ? in_passes() : many_leases();
    for (int rounds = 1; rounds < 40; rounds += 3) {
      CAPTURE(passes);
      CAPTURE(rounds);
      CrashStore store(0, 1);
      Service service(with_checks(1), &store);
      Hand ann(service, "ann");
      Hand bob(service, "bob");
      Hand liar(service, "liar");
      const JobId job = service.submit(small_scene(), settings);
      const Hands hands{{&ann, honest}, {&bob, honest}, {&liar, lying}};
      for (int i = 0; i < 100 && service.worker("liar").at("state") == "ready"; ++i) {
        work(service, hands, job, 1);
      }
      REQUIRE(service.worker("liar").at("state") == "quarantined");
      work(service, hands, job, rounds);
      store.crash();
      service.restart();
      ann.join();
      bob.join();
      work(service, {{&ann, honest}, {&bob, honest}}, job);
      REQUIRE(service.state(job) == "done");
      CHECK(service.sha256(job) == (passes ? reference_passes_sha256(small_scene(), settings)
                                           : reference_sha256(small_scene(), settings)));
      CHECK(contains(service.job(job).at("flag"), "'liar'"));
    }
  }
}

TEST_CASE("a liar is undone in every job that it has worked on, and gets no leases of any") {
  Service service(with_checks(1));
  Hand liar(service, "liar");
  const JobId first = service.submit(small_scene(), many_leases(), 90);
  work(service, {{&liar, lying}}, first, 3);
  RenderSettings other = many_leases();
  other.seed = 7;
  const JobId second = service.submit(small_scene(), other, 95);
  work(service, {{&liar, lying}}, second, 3);
  Hand ann(service, "ann");
  Hand bob(service, "bob");
  const Hands hands{{&liar, lying}, {&ann, honest}, {&bob, honest}};
  work(service, hands, second);
  work(service, hands, first);
  check_mended(service, second, other);
  check_mended(service, first, many_leases());
}

}  // namespace parray::test
