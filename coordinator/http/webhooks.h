#pragma once

#include <atomic>
#include <condition_variable>
#include <cstdint>
#include <functional>
#include <future>
#include <map>
#include <mutex>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "coordinator/http/loop_client.h"
#include "coordinator/store/job_record.h"

namespace parray::http {

/// The parts of a webhook's URL.
struct WebhookUrl {
  bool secure = false;
  std::string authority;  ///< "HOST[:PORT]" as in the URL
  std::string host;       ///< a name, or an address without brackets
  int port = 80;
  std::string path;  ///< with the query
};
/// Parses "http://HOST[:PORT][/PATH]", or https, of at most 1000 bytes. An IPv6 address stands in
/// brackets. Returns nothing if `text` has another form.
std::optional<WebhookUrl> webhook_url(const std::string& text);

/// Sends one POST with the JSON text `body`. Follows no redirect. Returns whether an answer with a
/// status of 2xx has arrived.
bool post_webhook(const WebhookUrl& url, const std::string& body);

/// Notifies other servers when a job has ended. It sends a POST with {"event": "job-ended", "job":
/// ...} to the URL that came with the job. Its thread repeats a failed POST up to five times, after
/// 1 s, then 5, 25 ... s, and then drops the webhook. The coordinator's store keeps pending
/// webhooks, so a standby and a backup have them, too. Callable from any thread.
class Webhooks {
 public:
  /// Sends a POST: see post_webhook(), which tests replace.
  using Post = std::function<bool(const WebhookUrl&, const std::string&)>;

  /// Stores the text of all pending webhooks. The result is ready when that is done.
  using Keep = std::function<std::future<void>(std::string)>;

  /// `loop` must outlive this object. `hosts`: hosts that webhooks may address. `pending`: the text
  /// that an earlier process stored last. `keep` may be empty: nothing outlives the process.
  Webhooks(LoopClient& loop, std::vector<std::string> hosts, const std::string& pending, Keep keep,
           Post post = post_webhook);
  ~Webhooks();
  Webhooks& operator=(Webhooks&&) = delete;

  /// Throws Problem 422 if `url` is invalid or its host is not permitted.
  void check(const std::string& url) const;
  /// Adds the webhook of a job, in place of an earlier one. Waits until it is stored, but at most
  /// ten seconds. Throws Problem 503 if stop() comes first.
  void add(JobId job, const std::string& url);
  /// Ends the thread that sends webhooks. The store keeps those that are pending.
  void stop();

 private:
  [[nodiscard]] bool permits(const std::optional<WebhookUrl>& url) const;
  struct Hook {
    std::string url;
    std::uint64_t added = 0;  ///< number of the add() that added it; 0: it comes from the file
    unsigned tries = 0;
    Time next_at{};
  };
  void run();
  void deliver_due(Time now);
  bool deliver(JobId job, Hook& hook, Time now);
  [[nodiscard]] std::future<void> save() const;

  LoopClient& loop_;
  const std::vector<std::string> hosts_;
  const Keep keep_;
  const Post post_;
  std::mutex mutex_;  // guards hooks_, added_ and the order of what is stored
  std::condition_variable changed_;
  std::map<JobId, Hook> hooks_;
  std::uint64_t added_ = 0;            ///< calls of add()
  std::atomic<bool> stopped_ = false;  ///< set under mutex_
  std::thread thread_;
};

}  // namespace parray::http
