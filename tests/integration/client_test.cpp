// The client with a minimal coordinator, in virtual time.
#include "cli/farm/client.h"

#include <doctest/doctest.h>

#include <deque>
#include <exception>
#include <functional>
#include <map>
#include <memory>
#include <set>
#include <stdexcept>
#include <string>
#include <vector>

#include "common/base/error.h"
#include "common/scene/settings.h"
#include "tests/support/message_of.h"
#include "tests/support/rooms.h"
#include "tests/support/sample_scenes.h"

namespace parray {
namespace {

using test::message_of;
using test::small_scene;

/// Link and clock of a client. A wait without a message advances the clock by its whole time.
class ScriptedLink final : public Link, public Clock {
 public:
  using Answer = std::function<void(Message&)>;
  /// Calls `answer` with every sent message; `answer` puts replies into `arrived`.
  explicit ScriptedLink(Answer answer) : answer_(std::move(answer)) {}

  bool send(const PeerId& /*to*/, Envelope content) override {
    Message message = content.open();
    ++sent;
    answer_(message);
    return true;
  }
  std::optional<Delivery> receive() override {
    if (arrived.empty()) return {};
    Delivery delivery{{}, Envelope(std::move(arrived.front()))};
    arrived.pop_front();
    return delivery;
  }
  void wait(Time timeout) override {
    if (arrived.empty()) now_ += timeout + extra;
    extra = Time(0);
  }
  void wake() noexcept override {}
  [[nodiscard]] Time now() const override { return now_; }

  std::deque<Frames> arrived;
  int sent = 0;
  Time extra{};  ///< by how much the next wait is longer than asked

 private:
  Answer answer_;
  Time now_ = seconds(1000);
};

Submission some_submission(std::size_t spheres) {
  Submission submission;
  submission.name = "a.json";
  submission.settings->precision = Precision::f32;
  submission.settings->accelerator = AcceleratorKind::bvh;
  submission.settings->row_order = RowOrder::sequential;
  Scene scene = small_scene();
  scene.spheres.resize(spheres, scene.spheres.front());
  submission.scene = std::make_shared<const Scene>(std::move(scene));
  return submission;
}

Submission some_frame(std::uint32_t frame) {
  Submission submission = some_submission(1);
  submission.series = "series";
  submission.frame = frame;
  submission.frames = 100;
  return submission;
}

Client::Options options() { return {.address = "tcp://somewhere:7400"}; }

}  // namespace

TEST_CASE("a request is repeated every half second until its answer comes") {
  ScriptedLink link([&](Message& message) {
    const auto& asked = std::get<msg::ListWorkers>(message);
    if (link.sent == 4) link.arrived.push_back(encode(msg::Workers{asked.request, {"w"}, 1}));
  });
  Client client(link, link, options());
  const Time begin = link.now();
  CHECK(client.workers() == nlohmann::json{"w"});
  CHECK(link.sent == 4);
  CHECK(link.now() - begin == milliseconds(1500));
}

TEST_CASE("the client gives up after ten seconds without an answer, and names the coordinator") {
  ScriptedLink link([](Message&) {});
  Client client(link, link, options());
  const Time begin = link.now();
  CHECK(message_of<RunError>([&] { client.jobs(); }) ==
        "no answer from the coordinator at tcp://somewhere:7400: is parray-coordinator running "
        "there?");
  CHECK(link.now() - begin == seconds(10));
  CHECK(link.sent == 20);
}

TEST_CASE("a scene is not sent to a coordinator that does not answer") {
  ScriptedLink link(
      [](Message& message) { CHECK(std::holds_alternative<msg::ListWorkers>(message)); });
  Client client(link, link, options());
  CHECK_THROWS_AS(client.submit(some_submission(100)), RunError);
}

TEST_CASE("a change is answered when it is stored: the client waits longer for it than for reads") {
  ScriptedLink link([&](Message& message) {
    if (const auto* asked = std::get_if<msg::ListWorkers>(&message)) {
      link.arrived.push_back(encode(msg::Workers{asked->request, nlohmann::json::array()}));
    } else if (link.sent > 100) {
      const auto& change = std::get<msg::SteerJob>(message);
      link.arrived.push_back(encode(msg::Job{change.request, {{"id", 7}}}));
    }
  });
  Client client(link, link, options());
  CHECK(client.steer(7, msg::JobAction::cancel).at("id") == 7);
}

TEST_CASE("time during which the client's process was stopped does not count as silence") {
  ScriptedLink link([&](Message& message) {
    const auto& asked = std::get<msg::ListJobs>(message);
    if (link.sent == 3) link.arrived.push_back(encode(msg::Jobs{asked.request, {1}}));
    link.extra = std::chrono::hours(1);
  });
  Client client(link, link, options());
  CHECK(client.jobs() == nlohmann::json{1});
}

TEST_CASE("the client waits for a coordinator that has answered once, and says so once") {
  std::vector<std::string> told;
  bool silent = false;
  Time ended = never;
  ScriptedLink link([&](Message& message) {
    if (!silent || link.now() >= ended) {
      const auto& asked = std::get<msg::ListJobs>(message);
      link.arrived.push_back(encode(msg::Jobs{asked.request, {1}}));
    }
  });
  Client client(link, link,
                {.address = "tcp://somewhere:7400",
                 .on_silence = [&](const auto& line) { told.push_back(line); }});
  client.jobs();
  silent = true;
  ended = link.now() + seconds(3600);
  CHECK(client.jobs() == nlohmann::json{1});
  CHECK(link.now() >= ended);
  REQUIRE(told.size() == 1);
  CHECK(told[0].find("no answer from the coordinator at tcp://somewhere:7400") == 0);
}

TEST_CASE("late and foreign answers are ignored") {
  ScriptedLink link([&](Message& message) {
    const auto& asked = std::get<msg::ShowJob>(message);
    const nlohmann::json wrong = {{"id", 0}};
    link.arrived.push_back(encode(msg::Job{asked.request + 1, wrong}));
    link.arrived.push_back(encode(msg::Jobs{asked.request, {}}));
    link.arrived.push_back(encode(msg::Error{asked.request + 1, 1, "not for this request"}));
    link.arrived.push_back(encode(msg::HeartbeatAck{}));
    link.arrived.push_back({Frame(std::string("damaged"))});
    link.arrived.push_back(encode(msg::Job{asked.request, {{"id", asked.job}}}));
  });
  Client client(link, link, options());
  CHECK(client.show(7).at("id") == 7);
  CHECK(client.show(8).at("id") == 8);
}

TEST_CASE("an error answer is an InputError or a RunError, with the coordinator's words") {
  std::uint32_t status = 2;
  ScriptedLink link([&](Message& message) {
    const auto& asked = std::get<msg::ShowJob>(message);
    link.arrived.push_back(encode(msg::Error{asked.request, status, "no job 3"}));
  });
  Client client(link, link, options());
  CHECK(message_of<InputError>([&] { client.show(3); }) == "no job 3");
  status = 1;
  CHECK(message_of<RunError>([&] { client.show(3); }) == "no job 3");
}

TEST_CASE("unreadable answers are not treated as missing ones") {
  ScriptedLink link(
      [&](Message&) { link.arrived.push_back({Frame(std::string("\x81\xA1v\x63"))}); });
  Client client(link, link, options());
  const std::string message = message_of<RunError>([&] { client.jobs(); });
  CHECK_MESSAGE(message.find("of the same release") != std::string::npos, message);
}

TEST_CASE("a repeated submit keeps its token, and another submit has another token") {
  std::multiset<std::string> tokens;
  ScriptedLink link([&](Message& message) {
    if (const auto* probe = std::get_if<msg::ListWorkers>(&message)) {
      link.arrived.push_back(encode(msg::Workers{probe->request, nlohmann::json::array(), 0}));
      return;
    }
    const auto& submit = std::get<msg::Submit>(message);
    tokens.insert(submit.token);
    if (tokens.count(submit.token) == 3) {
      link.arrived.push_back(encode(msg::Submitted{submit.request, 42}));
    }
  });
  Client client(link, link, options());
  CHECK(client.submit(some_submission(10)) == 42);
  const Time begin = link.now();
  CHECK(client.submit(some_submission(500'000)) == 42);
  CHECK(tokens.size() == 6);
  CHECK(std::set(tokens.begin(), tokens.end()).size() == 2);
  // 20 MB (40 bytes a sphere, and the head) are given two seconds more before they are sent again.
  CHECK(link.now() - begin >= 2 * milliseconds(2500));
  CHECK(link.now() - begin < 2 * milliseconds(2501));
}

TEST_CASE("pending submissions accept answers in any order, while other requests are made") {
  std::vector<msg::Submit> held;
  ScriptedLink link([&](Message& message) {
    if (auto* submit = std::get_if<msg::Submit>(&message)) {
      held.push_back(std::move(*submit));
    } else if (const auto* asked = std::get_if<msg::ListWorkers>(&message)) {
      link.arrived.push_back(encode(msg::Submitted{held.at(2).request, 13}));
      link.arrived.push_back(encode(msg::Workers{asked->request, {"w"}, 1}));
      link.arrived.push_back(encode(msg::Error{held.at(0).request, 2, "too large", false}));
      link.arrived.push_back(encode(msg::Error{held.at(1).request, 2, "no room", true}));
    }
  });
  Client client(link, link, options());
  for (std::uint32_t frame = 0; frame < 3; ++frame) client.start_submit(some_frame(frame));
  CHECK(client.submitting() == 3);
  CHECK(client.submitting_bytes() > 0);
  CHECK(client.workers() == nlohmann::json{"w"});
  std::map<std::uint32_t, Client::Outcome> outcomes;
  while (auto outcome = client.take_outcome(seconds(1))) {
    const std::uint32_t frame = outcome->submission.frame;
    outcomes.emplace(frame, std::move(*outcome));
  }
  REQUIRE(outcomes.size() == 3);
  CHECK(outcomes.at(2).job == 13);
  CHECK_FALSE(outcomes.at(2).refusal);
  CHECK_THROWS_WITH_AS(std::rethrow_exception(outcomes.at(0).refusal), "too large", InputError);
  CHECK_THROWS_WITH_AS(std::rethrow_exception(outcomes.at(1).refusal), "no room", NoRoom);
  CHECK(outcomes.at(1).submission.scene);
  CHECK(client.submitting() == 0);
  CHECK(client.submitting_bytes() == 0);
  CHECK_FALSE(client.take_outcome(seconds(1)));
}

TEST_CASE("pending submissions with lost messages are repeated with their tokens") {
  std::map<std::string, int> tokens;
  ScriptedLink link([&](Message& message) {
    const auto& submit = std::get<msg::Submit>(message);
    if (++tokens[submit.token] == 3) {
      link.arrived.push_back(encode(msg::Submitted{submit.request, 5}));
    }
  });
  Client client(link, link, options());
  client.start_submit(some_frame(7));
  client.start_submit(some_frame(8));
  const Time begin = link.now();
  CHECK(client.take_outcome(seconds(60)));
  CHECK(client.take_outcome(seconds(60)));
  CHECK(tokens == std::map<std::string, int>{{"series-7", 3}, {"series-8", 3}});
  CHECK(link.now() - begin >= seconds(1));
  CHECK(link.now() - begin < seconds(2));
}

TEST_CASE("the client says once that pending submissions get no answer") {
  ScriptedLink link([&](Message& message) {
    if (const auto* asked = std::get_if<msg::ListWorkers>(&message)) {
      link.arrived.push_back(encode(msg::Workers{asked->request, nlohmann::json::array(), 1}));
    }
  });
  int told = 0;
  Client::Options with_notice = options();
  with_notice.on_silence = [&](const std::string&) { ++told; };
  Client client(link, link, with_notice);
  client.workers();
  client.start_submit(some_frame(1));
  for (int i = 0; i < 100; ++i) {
    CHECK_FALSE(client.take_outcome(milliseconds(500)));
    CHECK((told == (i < 19 ? 0 : 1) || i == 19));  // a moment longer for the bytes
  }
}

TEST_CASE("an exception of the poll function ends a request and a pause") {
  ScriptedLink link([](Message&) {});
  int polls = 0;
  Client client(link, link, {.address = "a", .poll = [&] {
                               if (++polls == 10) throw std::logic_error("stop");
                             }});
  CHECK_THROWS_AS(client.jobs(), std::logic_error);
  polls = 0;
  CHECK_THROWS_AS(client.rest(std::chrono::hours(1)), std::logic_error);
}

TEST_CASE("a pause drops messages and does not spin on them") {
  ScriptedLink link([](Message&) {});
  int polls = 0;
  Client client(link, link, {.address = "a", .poll = [&] { ++polls; }});
  link.arrived.push_back(encode(msg::HeartbeatAck{}));
  const Time begin = link.now();
  client.rest(seconds(1));
  CHECK(link.now() - begin == seconds(1));
  CHECK(polls <= 2 * 22);
  CHECK(link.arrived.empty());
}

TEST_CASE("a picture that differs from the hash in its report is refused") {
  const Image image{2, 1, {0, 0.25F, 0.5F, 0.75F, 1, 2}};
  nlohmann::json report = {{"image_sha256", image_sha256(image)}};
  int damaged = 0;
  ScriptedLink link([&](Message& message) {
    if (const auto* show = std::get_if<msg::ShowJob>(&message)) {
      const nlohmann::json map = {{"id", 5},
                                  {"name", "a"},
                                  {"state", "done"},
                                  {"priority", 50},
                                  {"progress", 1.0},
                                  {"width", 2},
                                  {"height", 1},
                                  {"samples_per_second", 0.0},
                                  {"seconds_left", -1.0},
                                  {"reason", ""},
                                  {"samples_per_pixel", 1},
                                  {"sampler", "sobol"}};
      link.arrived.push_back(encode(msg::Job{show->request, map}));
      return;
    }
    const auto& fetch = std::get<msg::Fetch>(message);
    const std::string pixels(reinterpret_cast<const char*>(image.rgb.data()),
                             image.rgb.size() * sizeof(float));
    Frames frames = encode(msg::ImageData{fetch.request, report, 2, 1, false, false,
                                          PicturePayload(Bulk::of(pixels))});
    if (damaged-- > 0) {  // on its way
      frames[1] = Frame(std::string(pixels.size(), 'x'));
    }
    link.arrived.push_back(std::move(frames));
  });
  std::vector<std::string> told;
  Client client(link, link,
                {.address = "here", .on_silence = [&](const auto& line) { told.push_back(line); }});
  CHECK(client.fetch(5).image.rgb == image.rgb);
  damaged = 1;
  CHECK(client.fetch(5).image.rgb == image.rgb);
  damaged = 1000;
  CHECK(client.fetch(5).image.rgb == image.rgb);
  REQUIRE(told.size() == 1);
  CHECK_MESSAGE(told[0].find("checksum): check the network") != std::string::npos, told[0]);
  report["image_sha256"] = std::string(64, '0');
  CHECK_THROWS_AS(client.fetch(5), RunError);
  report.clear();
  CHECK_THROWS_AS(client.fetch(5), RunError);
}

TEST_CASE("a job map that lacks something is an error, not a guess") {
  CHECK_THROWS_AS(job_status({{"id", 1}}), RunError);
  CHECK_THROWS_AS(job_status("job"), RunError);
}

TEST_CASE("an answer that lacks something is called damaged, and other failures keep their words") {
  const nlohmann::json answer = {{"id", 1}};
  const auto lacking = reading_answers([&] { return answer.at("state").get<int>(); });
  const std::string damaged = message_of<RunError>([&] { (void)lacking(); });
  CHECK_MESSAGE(damaged.find("the coordinator's answer is damaged (") == 0, damaged);
  const auto failing = reading_answers([]() -> int { throw RunError("the disk is full"); });
  CHECK(message_of<RunError>([&] { (void)failing(); }) == "the disk is full");
  CHECK(reading_answers([&] { return answer.at("id").get<int>(); })() == 1);
}

}  // namespace parray
