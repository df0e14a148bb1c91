#include <doctest/doctest.h>

#include <chrono>
#include <filesystem>
#include <fstream>
#include <map>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "common/base/error.h"
#include "coordinator/http/events.h"
#include "coordinator/http/exchange.h"
#include "coordinator/http/guard.h"
#include "coordinator/http/loop_client.h"
#include "coordinator/http/router.h"
#include "coordinator/http/upload_reader.h"
#include "proto/inproc_link.h"
#include "proto/keys.h"
#include "tests/support/rooms.h"
#include "tests/support/running_loop.h"
#include "tests/support/temporary_directory.h"

namespace parray::http {
namespace {

using test::RunningLoop;
using test::submit_to;
using Head = std::map<std::string, std::string>;

Request request(const std::string& method, const std::string& path, const Head& head = {}) {
  Request made;
  made.method = method;
  made.path = path;
  made.field = [head](const char* name) {
    const auto found = head.find(name);
    return found == head.end() ? "" : found->second;
  };
  return made;
}

template <typename Work>
int status_of(const Work& work) {
  try {
    work();
  } catch (const Problem& problem) {
    return problem.status();
  }
  return 200;
}

template <typename Work>
std::string detail_of_problem(const Work& work) {
  try {
    work();
  } catch (const Problem& problem) {
    return problem.what();
  }
  return "";
}

Router sample_router() {
  Router router;
  const auto named = [](const char* name) {
    return [name](const Request& asked) {
      return text_reply(name + (asked.arguments.empty() ? "" : " " + asked.arguments.front()));
    };
  };
  router.add("GET", "/", named("page"));
  router.add("GET", "/jobs", named("list"), {"limit", "before"});
  router.add("POST", "/jobs", named("submit"));
  router.add("GET", "/jobs/{id}", named("show"));
  router.add("POST", "/jobs/{id}/pause", named("pause"));
  router.add("POST", "/jobs/pause", named("pause many"));
  return router;
}

std::string answered(const Router& router, Request asked) {
  const Router::Match match = router.find(asked);
  asked.arguments = match.arguments;
  return *match.route->answer(asked).body;
}

TEST_CASE("the router finds the handler of a method and a path") {
  const Router router = sample_router();
  CHECK(answered(router, request("GET", "/")) == "page");
  CHECK(answered(router, request("GET", "/jobs")) == "list");
  CHECK(answered(router, request("HEAD", "/jobs")) == "list");
  CHECK(answered(router, request("POST", "/jobs")) == "submit");
  CHECK(answered(router, request("GET", "/jobs/7")) == "show 7");
  CHECK(answered(router, request("POST", "/jobs/7/pause")) == "pause 7");
}

TEST_CASE("an unknown path is 404, an unsupported method is 405 with the supported methods") {
  const Router router = sample_router();
  for (const char* path : {"/nothing", "/jobs/", "/jobs/7/", "/jobs/7/pause/9", "", "jobs"}) {
    CHECK_MESSAGE(status_of([&] { (void)router.find(request("GET", path)); }) == 404, path);
  }
  try {
    (void)router.find(request("DELETE", "/jobs"));
    FAIL("DELETE was accepted");
  } catch (const Problem& problem) {
    CHECK(problem.status() == 405);
    REQUIRE(problem.headers().size() == 1);
    CHECK(problem.headers()[0].second == "GET, POST");
  }
}

TEST_CASE("a path with a name of its own is no job") {
  const Router router = sample_router();
  CHECK(answered(router, request("POST", "/jobs/pause")) == "pause many");
  try {
    (void)router.find(request("GET", "/jobs/pause"));
    FAIL("GET was accepted");
  } catch (const Problem& problem) {
    CHECK(problem.status() == 405);
    REQUIRE(problem.headers().size() == 1);
    CHECK(problem.headers()[0].second == "POST");
  }
}

TEST_CASE("unknown parameters, with a suggestion, and repeated parameters are refused") {
  const Router router = sample_router();
  Request asked = request("GET", "/jobs");
  asked.query = {{"limt", "3"}};
  CHECK(detail_of_problem([&] { (void)router.find(asked); }) ==
        "unknown parameter 'limt': did you mean 'limit'?");
  asked.query = {{"limit", "3"}, {"limit", "4"}};
  CHECK(status_of([&] { (void)router.find(asked); }) == 400);
}

TEST_CASE("a numeric parameter has plain digits and a value in its range") {
  CHECK(whole_number("id", "7", 1, 9) == 7);
  for (const char* text : {"", "0", "10", "-1", "+7", "7 ", "0x7", "1e0", "99999999999999999999"}) {
    CHECK_MESSAGE(status_of([&] { whole_number("id", text, 1, 9); }) == 400, text);
  }
}

TEST_CASE("without keys the guard refuses unknown hosts and changes by other sites") {
  const Guard guard({}, {"farm.example"});
  const auto status = [&](const std::string& method, const Head& head) {
    return status_of([&] { guard.check_origin(request(method, "/api/v1/jobs", head)); });
  };
  for (const char* host :
       {"localhost:7480", "127.0.0.1:7480", "[::1]:7480", "10.1.2.3", "farm.example:80"}) {
    CHECK_MESSAGE(status("GET", {{"host", host}}) == 200, host);
  }
  // Names that a foreign DNS could point at this server.
  for (const char* host : {"", "evil.example:7480", "localhost.evil.example", "127.0.0.1.nip.io",
                           "[::1", "[]", "127.1.1.1.1"}) {
    CHECK_MESSAGE(status("GET", {{"host", host}}) == 421, host);
  }
  const std::string host = "localhost:7480";
  CHECK(status("POST", {{"host", host}}) == 200);
  CHECK(status("POST", {{"host", host}, {"origin", "http://localhost:7480"}}) == 200);
  CHECK(status("POST", {{"host", host}, {"origin", "https://farm.example"}}) == 200);
  CHECK(status("POST", {{"host", host}, {"origin", "http://localhost:8000"}}) == 403);
  CHECK(status("POST", {{"host", host}, {"origin", "https://evil.example"}}) == 403);
  CHECK(status("DELETE", {{"host", host}, {"origin", "null"}}) == 403);
  CHECK(status("PUT", {{"host", host}, {"sec-fetch-site", "cross-site"}}) == 403);
  CHECK(status("GET", {{"host", host}, {"origin", "https://evil.example"}}) == 200);
}

TEST_CASE("a token is valid until it is replaced or its owner is removed") {
  const test::TemporaryDirectory directory;
  const auto keys = directory.path() / "keys";
  make_farm_keys(keys);
  add_member_key(keys, Role::client, "ann");
  const std::string first = make_token(keys, "ann");
  const std::string admin = make_token(keys, "admin");
  CHECK(first.size() == 50);
  CHECK(first != make_token(keys, "admin"));
  std::ifstream file(keys / "tokens");
  const std::string kept{std::istreambuf_iterator<char>(file), {}};
  CHECK(kept.find(first) == std::string::npos);

  TokenList tokens(keys);
  const auto ann = tokens.find(seconds(1), first);
  REQUIRE(ann);
  CHECK(ann->name == "ann");
  CHECK(ann->role == Role::client);
  CHECK_FALSE(tokens.find(seconds(1), admin));  // replaced above
  CHECK_FALSE(tokens.find(seconds(1), first + "x"));
  CHECK_FALSE(tokens.find(seconds(1), ""));

  const std::string second = make_token(keys, "ann");
  CHECK_FALSE(tokens.find(seconds(5), first));
  CHECK(tokens.find(seconds(5), second));
  remove_member_key(keys, "ann");
  remove_token(keys, "ann");
  add_member_key(keys, Role::client, "ann");  // another user with this name
  CHECK_FALSE(tokens.find(seconds(10), second));
  CHECK_THROWS_AS(make_token(keys, "nobody"), InputError);
  CHECK_THROWS_AS(make_token(keys, "worker"), InputError);
}

TEST_CASE("with keys a request needs a token, and any origin is permitted") {
  const test::TemporaryDirectory directory;
  const auto keys = directory.path() / "keys";
  make_farm_keys(keys);
  const std::string token = make_token(keys, "admin");
  Guard guard(keys, {});
  const auto admit = [&](const Head& head) { return guard.admit(request("GET", "/", head)); };
  CHECK(status_of([&] { admit({}); }) == 401);
  CHECK(status_of([&] { admit({{"authorization", token}}); }) == 401);
  CHECK(status_of([&] { admit({{"authorization", "Basic " + token}}); }) == 401);
  CHECK(status_of([&] { admit({{"authorization", "Bearer "}}); }) == 401);
  for (const char* scheme : {"Bearer ", "bearer ", "BEARER  "}) {
    CHECK(admit({{"authorization", scheme + token}}).role == Role::admin);
  }
  CHECK(status_of([&] { admit({{"authorization", "bearer" + token}}); }) == 401);
  CHECK(status_of([&] {
          guard.check_origin(request("POST", "/", {{"host", "x"}, {"origin", "http://y"}}));
        }) == 200);
}

TEST_CASE("options become arguments of the command line, according to name and type") {
  const RequestOptions options = read_options(
      R"({"adaptive": false, "name": "two  words", "passes": [1, 20.0], "progressive": true,
          "row_order": "auto", "spp": 7, "target_error": 0.01, "webhook": "http://a/b"})");
  CHECK(options.words == std::vector<std::string>{"--adaptive=off", "--name=two  words",
                                                  "--passes=1,20", "--progressive",
                                                  "--row-order=auto", "--spp=7",
                                                  "--target-error=0.01"});
  CHECK(options.webhook == "http://a/b");
  CHECK(read_options("").words.empty());
  for (const char* bad : {"[]",
                          "{",
                          "7",
                          "{\"spp\": \"7\"}",
                          "{\"spp\": null}",
                          "{\"adaptive\": 1}",
                          "{\"passes\": 3}",
                          "{\"passes\": [-1]}",
                          "{\"passes\": []}",
                          "{\"name\": \"\"}",
                          "{\"help\": true}",
                          "{\"--spp\": 3}",
                          "{\"a b\": 3}",
                          "{\"Select\": \"all\"}",
                          "{\"select\": {}}",
                          "{\"select\": []}",
                          "{\"select\": \"\"}",
                          "{\"select\": null}",
                          "{\"range\": [[1], 2]}",
                          "{\"show\": 3}",
                          "{\"show\": [{\"color_by\": \"z\"}]}"}) {
    CHECK_MESSAGE(status_of([&] { read_options(bad); }) == 422, bad);
  }
}

TEST_CASE("options that only the child knows are passed on, those of representations last") {
  CHECK(read_options(
            R"({"color_by": "z", "denoise": true, "range": [0, 1.5], "show":
                [{"select": "element N", "radius": 2}, "water"], "up": [0, 1, 1], "wrap": false})")
            .words == std::vector<std::string>{"--color-by=z", "--denoise=on", "--range=0:1.5",
                                               "--up=0,1,1", "--wrap=off", "--show=element N",
                                               "--radius=2", "--show=water"});
}

TEST_CASE("messages of the child name options by JSON pointers, but only options of the request") {
  const std::vector<std::string> words = {"--max-depth=0", "--selekt=all", "--color-by=vz"};
  const auto said = [&](const std::string& text) { return message_about_options(text, words); };
  CHECK(said("--max-depth: '0' is not a whole number; see `parray submit --help`") ==
        "options: /max_depth: '0' is not a whole number");
  CHECK(said("unknown option --selekt: did you mean --select? See `parray submit --help`") ==
        "options: /selekt: unknown option: did you mean 'select'?");
  CHECK(said("unknown option --selekt; see `parray submit --help`") ==
        "options: /selekt: unknown option");
  CHECK(said("--max-depth, --spp: too many") ==
        "options: /max_depth: --max-depth, --spp: too many");
  CHECK(said("a.xyz: --color-by: no column 'vz'") == "options: /color_by: a.xyz: no column 'vz'");
  CHECK(said("--spp: too many") == "--spp: too many");
  CHECK(said("a.json:7: /camera: wrong") == "a.json:7: /camera: wrong");
}

TEST_CASE("the loop answers requests in order, and its error messages are kept") {
  RunningLoop loop;
  LoopClient client(loop.hub());
  CHECK(client.ask<msg::Jobs>({}, msg::ListJobs{}).jobs.empty());
  CHECK(client.ask<msg::Workers>({}, msg::ListWorkers{}).total == 0);
  CHECK(detail_of_problem([&] {
          client.ask<msg::Job>({}, msg::ShowJob{0, 7});
        }) == "no job 7: parray jobs lists all jobs");
  // The key of a worker must not list jobs.
  CHECK(status_of([&] { client.ask<msg::Jobs>({Role::worker, "node"}, msg::ListJobs{}); }) == 409);
  // The loop checks ranges as it does for messages of other processes.
  CHECK(status_of([&] { client.ask<msg::Jobs>({}, msg::ListJobs{0, 0, 100000}); }) == 409);
  client.stop();
  CHECK(status_of([&] { client.ask<msg::Jobs>({}, msg::ListJobs{}); }) == 503);
}

TEST_CASE("a request waits longer for its answer if the loop may have to read a file") {
  CHECK(waits_for_disk<msg::Fetch>);
  CHECK(waits_for_disk<msg::FetchScene>);
  CHECK(waits_for_disk<msg::FetchJournal>);
  CHECK_FALSE(waits_for_disk<msg::ShowJob>);
}

/// Returns the next events of a stream; empty: none came within a minute, or the stream has ended.
std::string next_events(BodyStream& stream) {
  constexpr int most_comments = 12;  // one comes every five seconds
  for (int i = 0; i < most_comments; ++i) {
    const auto text = stream.next();
    if (!text) return {};
    if (*text != ":\n\n") return *text;
  }
  return {};
}

TEST_CASE("an event stream begins with all unfinished jobs, however many there are") {
  CoordinatorOptions options = test::service_options();
  options.limits.jobs = options.limits.user_jobs = 2000;
  RunningLoop loop(options);
  LoopClient client(loop.hub());
  for (int i = 0; i < 1001; ++i) submit_to(client, std::to_string(i));
  Events events(client, 10, std::chrono::hours(1));
  const auto stream = events.listen({});
  std::string text;
  while (text.find("\"id\":1001,") == std::string::npos) {
    const std::string more = next_events(*stream);
    REQUIRE(!more.empty());
    text += more;
  }
  CHECK(text.find("\"id\":1,") != std::string::npos);
}

TEST_CASE("an event stream that follows another one does not wait for the next regular poll") {
  RunningLoop loop;
  LoopClient client(loop.hub());
  const JobId job = submit_to(client, "a");
  Events events(client, 10, std::chrono::hours(1));
  const auto first = events.listen({});
  CHECK(next_events(*first).find("event: job") == 0);
  for (int i = 0; i < 3; ++i) {
    auto ending = events.listen(job + 1);
    CHECK(next_events(*ending).find("event: forgotten") == 0);
    CHECK(next_events(*ending).empty());
    ending.reset();
    const auto following = events.listen({});
    CHECK(next_events(*following).find("event: job") == 0);
  }
}

TEST_CASE("a merged link reads both links by turns, and sends each its own answers") {
  InprocHub outside;
  int woken = 0;
  InprocHub inside([&woken] { ++woken; });
  MergedLink joined(outside.coordinator(), inside.coordinator());
  const auto worker = outside.connect();
  const auto asker = inside.connect_as({Role::client, "ann"});
  for (int i = 0; i < 3; ++i) {
    worker->send({}, Message(msg::Identify{}));
    asker->send({}, asker->seal(msg::ListJobs{5}));
  }
  CHECK(woken == 3);
  std::vector<bool> from_inside;
  PeerId inner;
  PeerId outer;
  while (auto delivery = joined.receive()) {
    const bool is_inner = std::holds_alternative<msg::ListJobs>(delivery->content.open());
    from_inside.push_back(is_inner);
    (is_inner ? inner : outer) = delivery->peer;
    if (is_inner) CHECK(delivery->sender.name == "ann");
  }
  REQUIRE(from_inside.size() == 6);
  CHECK(from_inside[0] != from_inside[1]);
  CHECK(from_inside[2] != from_inside[3]);
  CHECK(inner != outer);
  CHECK(inner.front() == '\0');
  CHECK(joined.send(inner, Message(msg::HeartbeatAck{})));
  CHECK(asker->receive());
  CHECK_FALSE(worker->receive());
  CHECK(joined.send(outer, Message(msg::HeartbeatAck{})));
  CHECK(worker->receive());
}

}  // namespace
}  // namespace parray::http
