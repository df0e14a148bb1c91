#include "coordinator/http/webhooks.h"

#include <arpa/inet.h>
#include <httplib.h>

#include <algorithm>
#include <memory>
#include <nlohmann/json.hpp>
#include <sstream>

#include "common/base/json_text.h"
#include "common/base/printable.h"
#include "common/base/text.h"
#include "coordinator/http/events.h"

namespace parray::http {
namespace {

using nlohmann::json;

constexpr unsigned most_tries = 6;
constexpr Time first_pause = seconds(1);  // each further pause is five times as long

}  // namespace

std::optional<WebhookUrl> webhook_url(const std::string& text) {
  constexpr std::string_view plain = "http://";
  constexpr std::string_view secure = "https://";
  WebhookUrl url;
  url.secure = text.starts_with(secure);
  if ((!url.secure && !text.starts_with(plain)) || text.size() > 1000) return {};
  const bool clean = std::ranges::all_of(text, [](char c) { return c > ' ' && c < 127; });
  const std::string rest = text.substr(url.secure ? secure.size() : plain.size());
  const std::size_t slash = std::min(rest.find_first_of("/?#"), rest.size());
  url.authority = rest.substr(0, slash);
  url.path = rest.substr(slash, rest.find('#') - slash);
  if (!url.path.starts_with('/')) url.path.insert(0, "/");
  const bool numeric = url.authority.starts_with('[');  // an IPv6 address
  const std::size_t end = numeric ? url.authority.find(']') : url.authority.find(':');
  const bool found = end != std::string::npos;
  url.host = numeric ? url.authority.substr(1, end - 1) : url.authority.substr(0, end);
  url.port = url.secure ? 443 : 80;
  const std::string port = found ? url.authority.substr(end + (numeric ? 1 : 0)) : "";
  if (!port.empty()) {
    const auto number = parsed_between(std::string_view(port).substr(1), 1, 65535);
    if (!number || port.front() != ':') return {};
    url.port = *number;
  }
  in6_addr address{};
  const bool named = numeric ? found && inet_pton(AF_INET6, url.host.c_str(), &address) == 1
                             : !url.host.empty() && url.host.find('@') == std::string::npos;
  return clean && named ? std::optional(std::move(url)) : std::nullopt;
}

bool post_webhook(const WebhookUrl& url, const std::string& body) {
  // httplib::Client does not accept IPv6 addresses.
  const std::unique_ptr<httplib::ClientImpl> client =
      url.secure ? std::make_unique<httplib::SSLClient>(url.host, url.port)
                 : std::make_unique<httplib::ClientImpl>(url.host, url.port);
  client->set_connection_timeout(5);
  client->set_read_timeout(10);
  client->set_write_timeout(10);
  client->set_follow_location(false);
  const httplib::Result result =
      client->Post(url.path, {{"Host", url.authority}, {"User-Agent", "ParRay/" PARRAY_VERSION}},
                   body, "application/json");
  return result && result->status >= 200 && result->status < 300;
}

Webhooks::Webhooks(LoopClient& loop, std::vector<std::string> hosts, const std::string& pending,
                   Keep keep, Post post)
    : loop_(loop), hosts_(std::move(hosts)), keep_(std::move(keep)), post_(std::move(post)) {
  std::istringstream in(pending);
  JobId job = 0;
  for (std::string url; in >> job >> url;) {
    if (permits(webhook_url(url))) hooks_[job].url = url;
  }
  thread_ = std::thread([this] { run(); });
}

Webhooks::~Webhooks() {
  stop();
  thread_.join();
}

bool Webhooks::permits(const std::optional<WebhookUrl>& url) const {
  return url && std::ranges::find(hosts_, url->host) != hosts_.end();
}

void Webhooks::check(const std::string& url) const {
  const auto address = webhook_url(url);
  if (!address) {
    throw Problem(
        422,
        "options: /webhook: '" + printable(url, 200) +
            "' is not a URL for a webhook: use http://HOST:PORT/PATH or https://HOST:PORT/PATH "
            "(port and path are optional), at most 1000 ASCII characters without blanks",
        2);
  }
  if (!permits(address)) {
    throw Problem(422,
                  "options: /webhook: the host '" + printable(address->host) +
                      "' is not permitted: start the coordinator with --webhook-host " +
                      printable(address->host),
                  2);
  }
}

void Webhooks::add(JobId job, const std::string& url) {
  constexpr Time longest = seconds(10);
  std::future<void> kept;
  {
    const std::scoped_lock lock(mutex_);
    hooks_[job] = Hook{url, ++added_};
    kept = save();
  }
  changed_.notify_one();
  const SteadyClock clock;
  const Time end = clock.now() + longest;
  while (kept.valid() && kept.wait_for(milliseconds(10)) != std::future_status::ready) {
    if (stopped_) {
      throw Problem(503, "the coordinator is stopping, and the webhook of job " +
                             std::to_string(job) + " may be lost: ask for the job's state later");
    }
    if (clock.now() >= end) return;
  }
}

/// Stores the pending webhooks.
std::future<void> Webhooks::save() const {
  if (!keep_) return {};
  std::string text;
  for (const auto& [job, hook] : hooks_) text += std::to_string(job) + " " + hook.url + "\n";
  return keep_(std::move(text));
}

void Webhooks::stop() {
  {
    const std::scoped_lock lock(mutex_);
    stopped_ = true;
  }
  changed_.notify_one();
}

void Webhooks::run() {
  const SteadyClock clock;
  for (;;) {
    {
      std::unique_lock lock(mutex_);
      changed_.wait(lock, [this] { return stopped_ || !hooks_.empty(); });
      if (stopped_) return;
    }
    try {
      deliver_due(clock.now());
    } catch (const Problem&) {
      // The loop is busy or stopping: the next round asks again.
    }
    std::unique_lock lock(mutex_);
    changed_.wait_for(lock, seconds(1), [this] { return stopped_.load(); });
  }
}

void Webhooks::deliver_due(Time now) {
  constexpr std::size_t most_due = 50;  // jobs per round
  std::map<JobId, Hook> due;
  {
    const std::scoped_lock lock(mutex_);
    for (const auto& [job, hook] : hooks_) {
      if (hook.next_at <= now && due.size() < most_due) due.emplace(job, hook);
    }
  }
  for (auto& [job, hook] : due) {
    const bool settled = deliver(job, hook, now);
    const std::scoped_lock lock(mutex_);
    if (stopped_) return;
    if (hooks_.at(job).added != hook.added) continue;  // add() has replaced it meanwhile
    if (settled) {
      hooks_.erase(job);
      static_cast<void>(save());
    } else {
      hooks_[job] = hook;
    }
  }
}

/// Sends the webhook if its job has ended. Returns whether the webhook is settled.
bool Webhooks::deliver(JobId job, Hook& hook, Time now) {
  json shown;
  try {
    shown = loop_.ask<msg::Job>({}, msg::ShowJob{0, job}).job;
  } catch (const Problem& problem) {
    if (problem.status() != 409) throw;
    return true;  // the job was deleted
  }
  if (!has_ended(shown)) {
    hook.next_at = now + milliseconds(1500);
    return false;
  }
  const auto url = webhook_url(hook.url);
  const json body = {{"event", "job-ended"}, {"job", std::move(shown)}};
  if (!url || post_(*url, json_text(body))) return true;
  Time pause = first_pause;
  for (unsigned i = 0; i < hook.tries; ++i) pause *= 5;
  hook.next_at = now + pause;
  return ++hook.tries >= most_tries;
}

}  // namespace parray::http
