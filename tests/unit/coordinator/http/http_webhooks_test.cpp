#include <doctest/doctest.h>

#include <atomic>
#include <chrono>
#include <future>
#include <memory>
#include <string>
#include <thread>
#include <vector>

#include "coordinator/http/exchange.h"
#include "coordinator/http/loop_client.h"
#include "coordinator/http/webhooks.h"
#include "tests/support/rooms.h"
#include "tests/support/running_loop.h"

namespace parray::http {
namespace {

using test::RunningLoop;
using test::submit_to;

/// Stores the text of pending webhooks in `text`.
Webhooks::Keep keep_in(std::string& text) {
  return [&text](std::string now) {
    text = std::move(now);
    std::promise<void> kept;
    kept.set_value();
    return kept.get_future();
  };
}

TEST_CASE("the URL of a webhook has a scheme, a host, a port and a path") {
  const auto url = webhook_url("https://hooks.example:8443/a/b?c=d#e");
  REQUIRE(url);
  CHECK(url->secure);
  CHECK(url->host == "hooks.example");
  CHECK(url->port == 8443);
  CHECK(url->path == "/a/b?c=d");
  CHECK(url->authority == "hooks.example:8443");
  CHECK(webhook_url("http://h")->path == "/");
  CHECK(webhook_url("http://h?x")->path == "/?x");
  for (const char* bad : {"",
                          "h/p",
                          "ftp://h/",
                          "http://",
                          "http:///p",
                          "http://u@h/",
                          "http://h:0/",
                          "http://h:99999/",
                          "http://h:/",
                          "http://h:8x/",
                          "http://h/ p",
                          "http://h/\np",
                          "http://[::1/",
                          "http://[]/",
                          "http://[::1]8000/",
                          "http://[::1]:/",
                          "http://[h]/",
                          "http://[127.0.0.1]/",
                          "http://[fe80::1%eth0]/",
                          "http://::1/"}) {
    CHECK_MESSAGE(!webhook_url(bad), bad);
  }
}

TEST_CASE("the host of a webhook's URL may be an IPv6 address in brackets") {
  const auto url = webhook_url("http://[2001:db8::a1]:8000/x");
  REQUIRE(url);
  CHECK(url->authority == "[2001:db8::a1]:8000");
  CHECK(url->host == "2001:db8::a1");
  CHECK(url->port == 8000);
  CHECK(url->path == "/x");
  CHECK(webhook_url("https://[::1]")->port == 443);
}

TEST_CASE("a pending webhook is dropped if the next process does not permit its host") {
  std::string text = "7 http://h/x\n8 http://g/x\n";
  RunningLoop loop;
  LoopClient client(loop.hub());
  client.stop();  // so that no webhook is sent
  Webhooks(client, {"g"}, text, keep_in(text)).add(9, "http://g/y");
  CHECK(text == "8 http://g/x\n9 http://g/y\n");
}

TEST_CASE("webhooks permit listed hosts only, and pending ones outlive the process") {
  // Without an answer of the coordinator no POST is sent, and the webhook stays.
  std::string text;
  RunningLoop loop;
  LoopClient client(loop.hub());
  std::atomic<int> posts = 0;
  const auto post = [&](const WebhookUrl&, const std::string&) {
    ++posts;
    return false;
  };
  {
    Webhooks hooks(client, {"h"}, "", keep_in(text), post);
    CHECK_NOTHROW(hooks.check("http://h/x"));
    try {
      hooks.check("http://other/x");
      FAIL("the host was permitted");
    } catch (const Problem& problem) {
      CHECK(problem.status() == 422);
    }
    client.stop();  // the loop does not answer
    hooks.add(7, "http://h/x");
  }
  CHECK(text == "7 http://h/x\n");
  CHECK(posts == 0);
}

TEST_CASE("a webhook is added when it is stored") {
  RunningLoop loop;
  LoopClient client(loop.hub());
  client.stop();
  std::atomic<bool> stored = false;
  std::promise<void> kept;
  std::jthread storing;
  const auto keep = [&](const std::string&) {
    storing = std::jthread([&] {
      std::this_thread::sleep_for(std::chrono::milliseconds(30));
      stored = true;
      kept.set_value();
    });
    return kept.get_future();
  };
  Webhooks(client, {"h"}, "", keep).add(7, "http://h/x");
  CHECK(stored);
}

TEST_CASE("a webhook that is not stored when the coordinator stops is refused") {
  RunningLoop loop;
  LoopClient client(loop.hub());
  client.stop();
  std::promise<void> kept;
  std::promise<void> asked;
  const auto keep = [&](const std::string&) {
    asked.set_value();
    return kept.get_future();
  };
  Webhooks hooks(client, {"h"}, "", keep);
  const std::jthread stopping([&] {
    asked.get_future().wait();
    hooks.stop();
  });
  int status = 0;
  try {
    hooks.add(7, "http://h/x");
  } catch (const Problem& problem) {
    status = problem.status();
  }
  CHECK(status == 503);
}

TEST_CASE("a webhook that is added while an earlier one of its job is being sent is sent, too") {
  for (const bool delivered : {true, false}) {
    CAPTURE(delivered);
    RunningLoop loop;
    LoopClient client(loop.hub());
    const JobId job = submit_to(client, "a");
    client.ask<msg::Job>({}, msg::SteerJob{0, job, msg::JobAction::cancel, 50});
    std::promise<void> sent;
    std::unique_ptr<Webhooks> hooks;
    const auto post = [&](const WebhookUrl& url, const std::string&) {
      if (url.path == "/second") {
        sent.set_value();
        return true;
      }
      hooks->add(job, "http://h/second");
      return delivered;
    };
    hooks = std::make_unique<Webhooks>(client, std::vector<std::string>{"h"}, "", Webhooks::Keep(),
                                       post);
    hooks->add(job, "http://h/first");
    CHECK(sent.get_future().wait_for(std::chrono::minutes(1)) == std::future_status::ready);
  }
}

}  // namespace
}  // namespace parray::http
