// A coordinator with keys, over real sockets: who is heard, and what they may say.
#include <doctest/doctest.h>
#include <spdlog/sinks/null_sink.h>
#include <spdlog/spdlog.h>

#include <atomic>
#include <thread>

#include "coordinator/coordinator.h"
#include "proto/zmq_link.h"
#include "tests/support/sample_scenes.h"
#include "tests/support/temporary_directory.h"

namespace parray::test {
namespace {

/// A farm's keys, and a coordinator in a thread of its own that wants them.
class KeyedServer {
 public:
  KeyedServer() {
    thread_ = std::thread([this] {
      run_actor(coordinator_, server_.link(), clock_, [this](Time) { return stop_.load(); });
    });
  }
  ~KeyedServer() {
    stop_ = true;
    thread_.join();
  }
  KeyedServer(const KeyedServer&) = delete;
  KeyedServer& operator=(const KeyedServer&) = delete;

  [[nodiscard]] const std::string& endpoint() const { return server_.endpoint(); }
  [[nodiscard]] const std::filesystem::path& keys() const { return keys_; }

 private:
  std::filesystem::path made_keys() {
    make_farm_keys(directory_.path() / "keys");
    return directory_.path() / "keys";
  }
  CoordinatorOptions options() {
    CoordinatorOptions options;
    options.fingerprint = "same";
    options.backroom.wake = [this] { server_.link().wake(); };
    return options;
  }

  TemporaryDirectory directory_;
  std::filesystem::path keys_ = made_keys();
  ZmqServer server_{"tcp://127.0.0.1:*", default_max_message_bytes, keys_};
  Coordinator coordinator_{
      options(), nullptr,
      std::make_shared<spdlog::logger>("silent", std::make_shared<spdlog::sinks::null_sink_mt>())};
  SteadyClock clock_;
  std::atomic<bool> stop_ = false;
  std::thread thread_;
};

class Speaker {
 public:
  Speaker(const KeyedServer& server, const std::optional<MemberKey>& key)
      : link_(zmq_connect(server.endpoint(), default_max_message_bytes, Time(0), key)) {}

  void say(const Message& message) { link_->send({}, message); }
  /// The next message of type M, if it comes in time.
  template <typename M>
  std::optional<M> hear(Time patience = seconds(20)) {
    const SteadyClock clock;
    for (const Time end = clock.now() + patience; clock.now() < end;) {
      if (auto delivery = link_->receive()) {
        Message message = delivery->content.open();
        if (auto* expected = std::get_if<M>(&message)) {
          return std::move(*expected);
        }
      } else {
        link_->wait(milliseconds(20));
      }
    }
    return {};
  }
  template <typename M>
  M must_hear() {
    auto heard = hear<M>();
    REQUIRE(heard);
    return std::move(*heard);
  }

 private:
  std::unique_ptr<Link> link_;
};

msg::Hello hello() { return {protocol_version, "w", "w", 1, 1, trace_version, "same"}; }

msg::Submit submission() {
  msg::Submit submit;
  submit.request = 1;
  submit.token = "token";
  submit.name = "scene";
  submit.settings = small_settings(small_scene());
  submit.scene = SceneParcel(std::make_shared<const Scene>(small_scene()));
  return submit;
}

bool contains(const std::string& text, const std::string& part) {
  return text.find(part) != std::string::npos;
}

}  // namespace

TEST_CASE("strangers are not heard: without a key, with one of their own, with another farm's") {
  const KeyedServer server;
  const KeyedServer elsewhere;
  MemberKey own = read_member_key(server.keys(), "admin");
  own.own = make_key_pair();
  MemberKey others = read_member_key(elsewhere.keys(), "admin");
  others.coordinator = read_member_key(server.keys(), "admin").coordinator;
  Speaker without(server, {});
  Speaker unknown(server, own);
  Speaker foreign(server, others);
  Speaker known(server, read_member_key(server.keys(), "admin"));
  for (Speaker* speaker : {&without, &unknown, &foreign, &known}) {
    speaker->say(msg::ListJobs{1});
  }
  CHECK(known.hear<msg::Jobs>());
  for (Speaker* speaker : {&without, &unknown, &foreign}) {
    CHECK_FALSE(speaker->hear<msg::Jobs>(milliseconds(200)));
  }
  // Nor does a member talk to who poses as the coordinator.
  MemberKey deceived = read_member_key(server.keys(), "admin");
  Speaker careful(elsewhere, deceived);
  careful.say(msg::ListJobs{1});
  CHECK_FALSE(careful.hear<msg::Jobs>(milliseconds(200)));
}

TEST_CASE("each role says what is its own, and is told when it says something else") {
  const KeyedServer server;
  add_member_key(server.keys(), Role::client, "ann");
  Speaker worker(server, read_member_key(server.keys(), "worker"));
  Speaker ann(server, read_member_key(server.keys(), "ann"));
  worker.say(hello());
  CHECK(worker.hear<msg::Welcome>());
  worker.say(submission());
  const auto error = worker.must_hear<msg::Error>();
  CHECK(error.request == 1);
  CHECK(error.status == 2);
  CHECK(contains(error.message, "the key 'worker' is that of a worker"));
  ann.say(hello());
  CHECK(contains(ann.must_hear<msg::Refuse>().reason, "the key 'ann' is that of a client"));
  ann.say(msg::ListWorkers{2});
  CHECK(ann.must_hear<msg::Workers>().total == 1);
  ann.say(submission());
  CHECK(ann.must_hear<msg::Submitted>().job == 1);
}

TEST_CASE("jobs are changed by those who own them, and by administrators") {
  const KeyedServer server;
  for (const char* name : {"ann", "bob"}) {
    add_member_key(server.keys(), Role::client, name);
  }
  Speaker ann(server, read_member_key(server.keys(), "ann"));
  Speaker bob(server, read_member_key(server.keys(), "bob"));
  Speaker admin(server, read_member_key(server.keys(), "admin"));
  ann.say(submission());
  REQUIRE(ann.must_hear<msg::Submitted>().job == 1);
  bob.say(submission());  // the same token: hers stays hers
  CHECK(bob.must_hear<msg::Submitted>().job == 2);

  bob.say(msg::ShowJob{1, 1});
  CHECK(bob.must_hear<msg::Job>().job.at("user") == "ann");
  for (const Message& change :
       {Message(msg::Pause{7, 1}), Message(msg::Resume{7, 1}), Message(msg::Cancel{7, 1})}) {
    bob.say(change);
    const auto error = bob.must_hear<msg::Error>();
    CHECK(error.status == 2);
    CHECK(contains(error.message, "job 1 is that of 'ann', not that of 'bob'"));
  }
  ann.say(msg::Pause{8, 1});
  CHECK(ann.must_hear<msg::Job>().job.at("state") == "paused");
  admin.say(msg::Cancel{9, 1});
  CHECK(admin.must_hear<msg::Job>().job.at("state") == "cancelled");
}

TEST_CASE("whose key is taken off the list is not heard any more, connected or not") {
  const KeyedServer server;
  add_member_key(server.keys(), Role::client, "ann");
  add_member_key(server.keys(), Role::worker, "old");
  const MemberKey key = read_member_key(server.keys(), "ann");
  Speaker ann(server, key);
  Speaker worker(server, read_member_key(server.keys(), "old"));
  Speaker admin(server, read_member_key(server.keys(), "admin"));
  ann.say(msg::ListJobs{1});
  CHECK(ann.hear<msg::Jobs>());
  worker.say(hello());
  CHECK(worker.hear<msg::Welcome>());
  remove_member_key(server.keys(), "ann");
  remove_member_key(server.keys(), "old");
  std::this_thread::sleep_for(milliseconds(1100));
  ann.say(msg::ListJobs{2});
  CHECK(contains(ann.must_hear<msg::Error>().message, "no longer allowed"));
  worker.say(msg::Heartbeat{});
  CHECK(contains(worker.must_hear<msg::Refuse>().reason, "no longer allowed"));
  admin.say(msg::ListWorkers{3});
  CHECK(admin.must_hear<msg::Workers>().total == 0);
  Speaker again(server, key);
  again.say(msg::ListJobs{4});
  CHECK_FALSE(again.hear<msg::Jobs>(milliseconds(200)));
}

}  // namespace parray::test
