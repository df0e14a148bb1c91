#pragma once

#include <condition_variable>
#include <filesystem>
#include <functional>
#include <map>
#include <mutex>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "coordinator/http/loop_client.h"
#include "coordinator/store/job_record.h"

namespace parray::http {

struct WebhookUrl {
  bool secure = false;
  std::string host;
  int port = 80;
  std::string path;
};
/// "http://HOST[:PORT][/PATH]", or https. None: it is no such address.
std::optional<WebhookUrl> webhook_url(const std::string& text);

/// One POST of `body`, JSON; no redirect is followed. True: it was taken (2xx).
bool post_webhook(const WebhookUrl& url, const std::string& body);

/// Tells others that jobs have ended: a POST of {"event": "job-ended", "job": ...} to the address
/// that came with the job. Tried again five times, ever more seldom, by a thread of its own; what
/// is to be told outlives the process. Any thread.
class Webhooks {
 public:
  using Post = std::function<bool(const WebhookUrl&, const std::string&)>;

  /// `hosts`: that may be told. `file`: where addresses are kept; empty: nowhere. Throws RunError.
  Webhooks(LoopClient& loop, std::vector<std::string> hosts, std::filesystem::path file,
           Post post = post_webhook);
  ~Webhooks();
  Webhooks(const Webhooks&) = delete;
  Webhooks& operator=(const Webhooks&) = delete;

  /// Throws Problem 422 unless such a host may be told.
  void check(const std::string& url) const;
  void add(JobId job, const std::string& url);
  void stop();

 private:
  struct Hook {
    std::string url;
    unsigned tries = 0;
    Time next_at{};
  };
  void run();
  void look(Time now);
  bool deliver(JobId job, Hook& hook, Time now);
  void keep() const;

  LoopClient& loop_;
  const std::vector<std::string> hosts_;
  const std::filesystem::path file_;
  const Post post_;
  std::mutex mutex_;  // guards hooks_, stopped_ and the file
  std::condition_variable changed_;
  std::map<JobId, Hook> hooks_;
  bool stopped_ = false;
  std::thread thread_;
};

}  // namespace parray::http
