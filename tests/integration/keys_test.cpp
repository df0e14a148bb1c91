// A coordinator with keys, over real sockets: which peers it accepts, and which messages of them.
#include <doctest/doctest.h>

#include <thread>

#include "tests/support/contains.h"
#include "tests/support/rooms.h"
#include "tests/support/sample_scenes.h"
#include "tests/support/served.h"
#include "tests/support/temporary_directory.h"

namespace parray::test {
namespace {

CoordinatorOptions options() {
  CoordinatorOptions options;
  options.fingerprint = "same";
  return options;
}

/// A farm's keys, and a coordinator that requires them.
class KeyedServer : TemporaryDirectory, public Server {
 public:
  KeyedServer() : Server(options(), made_keys()) {}
  [[nodiscard]] std::filesystem::path keys() const { return path() / "keys"; }

 private:
  [[nodiscard]] std::filesystem::path made_keys() const {
    make_farm_keys(keys());
    return keys();
  }
};

msg::Hello hello() { return {protocol_version, "w", "w", 1, 1, trace_version, "same"}; }

msg::Submit submission() {
  msg::Submit submit;
  submit.request = 1;
  submit.token = "token";
  submit.name = "scene";
  submit.settings = small_settings(small_scene());
  submit.scene = ScenePayload(std::make_shared<const Scene>(small_scene()));
  return submit;
}

}  // namespace

TEST_CASE("strangers are ignored: without a key, with their own key, with another farm's key") {
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
  for (Speaker* speaker : {&without, &unknown, &foreign, &known}) speaker->say(msg::ListJobs{1});
  CHECK(known.hear_within<msg::Jobs>(seconds(20)));
  for (Speaker* speaker : {&without, &unknown, &foreign}) {
    CHECK_FALSE(speaker->hear_within<msg::Jobs>(milliseconds(200)));
  }
  // A member sends nothing to a process that poses as the coordinator.
  MemberKey deceived = read_member_key(server.keys(), "admin");
  Speaker careful(elsewhere, deceived);
  careful.say(msg::ListJobs{1});
  CHECK_FALSE(careful.hear_within<msg::Jobs>(milliseconds(200)));
}

TEST_CASE("each role may send its own messages, and gets an error for others") {
  const KeyedServer server;
  add_member_key(server.keys(), Role::client, "ann");
  Speaker worker(server, read_member_key(server.keys(), "worker"));
  Speaker ann(server, read_member_key(server.keys(), "ann"));
  worker.say(hello());
  CHECK(worker.hear_within<msg::Welcome>(seconds(20)));
  worker.say(submission());
  const auto error = worker.hear<msg::Error>();
  CHECK(error.request == 1);
  CHECK(error.status == 2);
  CHECK(contains(error.message, "the key 'worker' has the role worker"));
  ann.say(hello());
  CHECK(contains(ann.hear<msg::Refuse>().reason, "the key 'ann' has the role client"));
  ann.say(msg::ListWorkers{2});
  CHECK(ann.hear<msg::Workers>().total == 1);
  ann.say(submission());
  CHECK(ann.hear<msg::Submitted>().job == 1);
}

TEST_CASE("only their owners and administrators can change jobs") {
  const KeyedServer server;
  for (const char* name : {"ann", "bob"}) add_member_key(server.keys(), Role::client, name);
  Speaker ann(server, read_member_key(server.keys(), "ann"));
  Speaker bob(server, read_member_key(server.keys(), "bob"));
  Speaker admin(server, read_member_key(server.keys(), "admin"));
  ann.say(submission());
  REQUIRE(ann.hear<msg::Submitted>().job == 1);
  bob.say(submission());  // the same token: the job of the first client remains hers
  CHECK(bob.hear<msg::Submitted>().job == 2);

  bob.say(msg::ShowJob{1, 1});
  CHECK(bob.hear<msg::Job>().job.at("user") == "ann");
  for (const Message& change : {Message(msg::SteerJob{7, 1, msg::JobAction::pause}),
                                Message(msg::SteerJob{7, 1, msg::JobAction::resume}),
                                Message(msg::SteerJob{7, 1, msg::JobAction::cancel})}) {
    bob.say(change);
    const auto error = bob.hear<msg::Error>();
    CHECK(error.status == 2);
    CHECK(contains(error.message, "job 1 belongs to 'ann', not to 'bob'"));
  }
  ann.say(msg::SteerJob{8, 1, msg::JobAction::pause});
  CHECK(ann.hear<msg::Job>().job.at("state") == "paused");
  admin.say(msg::SteerJob{9, 1, msg::JobAction::cancel});
  CHECK(admin.hear<msg::Job>().job.at("state") == "cancelled");
}

TEST_CASE("a peer with a removed key is ignored, connected or not") {
  const KeyedServer server;
  add_member_key(server.keys(), Role::client, "ann");
  add_member_key(server.keys(), Role::worker, "old");
  const MemberKey key = read_member_key(server.keys(), "ann");
  Speaker ann(server, key);
  Speaker worker(server, read_member_key(server.keys(), "old"));
  Speaker admin(server, read_member_key(server.keys(), "admin"));
  ann.say(msg::ListJobs{1});
  CHECK(ann.hear_within<msg::Jobs>(seconds(20)));
  worker.say(hello());
  CHECK(worker.hear_within<msg::Welcome>(seconds(20)));
  remove_member_key(server.keys(), "ann");
  remove_member_key(server.keys(), "old");
  std::this_thread::sleep_for(milliseconds(1100));
  ann.say(msg::ListJobs{2});
  CHECK(contains(ann.hear<msg::Error>().message, "no longer allowed"));
  worker.say(msg::Heartbeat{});
  CHECK(contains(worker.hear<msg::Refuse>().reason, "no longer allowed"));
  admin.say(msg::ListWorkers{3});
  CHECK(admin.hear<msg::Workers>().total == 0);
  Speaker again(server, key);
  again.say(msg::ListJobs{4});
  CHECK_FALSE(again.hear_within<msg::Jobs>(milliseconds(200)));
}

}  // namespace parray::test
