#include "coordinator/http/webhooks.h"

#include <algorithm>
#include <fstream>
#include <nlohmann/json.hpp>

#include "common/base/error.h"
#include "common/base/printable.h"
#include "common/base/suggest.h"
#include "common/base/text.h"

namespace parray::http {
namespace {

using nlohmann::json;

constexpr unsigned most_tries = 6;
constexpr Time first_rest = seconds(1);  // five times as long after every try

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
  const std::string authority = rest.substr(0, slash);
  url.path = rest.substr(slash, rest.find('#') - slash);
  if (!url.path.starts_with('/')) url.path.insert(0, "/");
  const std::size_t colon = authority.find(':');
  url.host = authority.substr(0, colon);
  url.port = url.secure ? 443 : 80;
  if (colon != std::string::npos) {
    const auto port = parsed_between(std::string_view(authority).substr(colon + 1), 1, 65535);
    if (!port) return {};
    url.port = *port;
  }
  const bool named = !url.host.empty() && url.host.find('@') == std::string::npos;
  return clean && named ? std::optional(std::move(url)) : std::nullopt;
}

Webhooks::Webhooks(LoopClient& loop, std::vector<std::string> hosts, std::filesystem::path file,
                   Post post)
    : loop_(loop), hosts_(std::move(hosts)), file_(std::move(file)), post_(std::move(post)) {
  std::ifstream in(file_);
  JobId job = 0;
  for (std::string url; in >> job >> url;) hooks_[job].url = url;
  thread_ = std::thread([this] { run(); });
}

Webhooks::~Webhooks() {
  stop();
  thread_.join();
}

void Webhooks::check(const std::string& url) const {
  const auto address = webhook_url(url);
  if (!address) {
    throw Problem(422,
                  "options: /webhook: '" + printable(url, 200) +
                      "' is no address: write http://HOST/PATH, or https",
                  2);
  }
  if (std::ranges::find(hosts_, address->host) == hosts_.end()) {
    throw Problem(422,
                  "options: /webhook: this server tells nothing to '" + printable(address->host) +
                      "': it must be started with --webhook-host " + printable(address->host),
                  2);
  }
}

void Webhooks::add(JobId job, const std::string& url) {
  {
    const std::scoped_lock lock(mutex_);
    hooks_[job].url = url;
    keep();
  }
  changed_.notify_one();
}

/// What cannot be kept is lost with the process: the job is none the worse for it.
void Webhooks::keep() const {
  if (file_.empty()) return;
  const std::filesystem::path fresh = file_.string() + ".new";
  std::ofstream out(fresh);
  for (const auto& [job, hook] : hooks_) out << job << " " << hook.url << "\n";
  out.close();
  std::error_code ignored;
  if (out) std::filesystem::rename(fresh, file_, ignored);
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
      look(clock.now());
    } catch (const Problem&) {
      // The loop is busy or ending: it is asked again.
    }
    std::unique_lock lock(mutex_);
    changed_.wait_for(lock, seconds(1), [this] { return stopped_; });
  }
}

void Webhooks::look(Time now) {
  constexpr std::size_t most_at_once = 50;  // jobs that the loop is asked for
  std::map<JobId, Hook> due;
  {
    const std::scoped_lock lock(mutex_);
    for (const auto& [job, hook] : hooks_) {
      if (hook.next_at <= now && due.size() < most_at_once) due.emplace(job, hook);
    }
  }
  for (auto& [job, hook] : due) {
    const bool settled = deliver(job, hook, now);
    const std::scoped_lock lock(mutex_);
    if (stopped_) return;
    if (settled) {
      hooks_.erase(job);
      keep();
    } else {
      hooks_[job] = hook;
    }
  }
}

/// True: nothing more is to be done.
bool Webhooks::deliver(JobId job, Hook& hook, Time now) {
  json shown;
  try {
    shown = loop_.ask<msg::Job>({}, msg::ShowJob{0, job}).job;
  } catch (const Problem& problem) {
    if (problem.status() != 409) throw;
    return true;  // forgotten
  }
  const std::string state = shown.at("state");
  if (state != "done" && state != "failed" && state != "cancelled") {
    hook.next_at = now + milliseconds(1500);
    return false;
  }
  const auto url = webhook_url(hook.url);
  const json body = {{"event", "job-ended"}, {"job", std::move(shown)}};
  if (!url || post_(*url, body.dump(-1, ' ', false, json::error_handler_t::replace))) return true;
  Time rest = first_rest;
  for (unsigned i = 0; i < hook.tries; ++i) rest *= 5;
  hook.next_at = now + rest;
  return ++hook.tries >= most_tries;
}

}  // namespace parray::http
