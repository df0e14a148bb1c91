#include "coordinator/http/events.h"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <utility>

#include "common/base/json_text.h"

namespace parray::http {
namespace {

using nlohmann::json;

constexpr const char* unfinished = "queued,running,paused,finishing";
constexpr std::uint32_t newest = 50;        ///< jobs polled in any state, to notice short ones
constexpr std::size_t most_queued = 20000;  ///< events that a slow listener may lag behind

std::string event_text(const char* name, const json& data) {
  return std::string("event: ") + name + "\ndata: " + json_text(data) + "\n\n";
}

/// Rounds what changes all the time, so that a heartbeat alone causes no event.
void round_times(json& worker) {
  const auto round = [](json& value, double step) {
    if (value.is_number()) value = std::floor(value.get<double>() / step) * step;
  };
  round(worker.at("seconds_silent"), 10);
  if (worker.contains("backoff_seconds")) round(worker["backoff_seconds"], 10);
  if (worker.contains("load")) round(worker["load"], 0.5);
  if (worker.contains("tracing") && worker["tracing"].is_object()) {
    round(worker["tracing"]["seconds"], 10);
  }
}

std::string forgotten_event(JobId job) { return event_text("forgotten", {{"id", job}}); }

}  // namespace

bool has_ended(const json& job) {
  const std::string state = job.at("state");
  return state == "done" || state == "failed" || state == "cancelled";
}

/// The queue of one listener.
class Events::Stream final : public BodyStream {
 public:
  /// `waits`: the stream only waits for its end.
  explicit Stream(std::optional<JobId> job, bool waits = false) : job_(job), waits_(waits) {}

  /// Returns the next events, or, after a time without events, a comment, which keeps the
  /// connection alive.
  std::optional<std::string> next() override {
    constexpr auto most_silence = seconds(5);  // then a comment reveals lost connections
    std::unique_lock lock(mutex_);
    changed_.wait_for(lock, most_silence, [this] { return closed_ || !queue_.empty(); });
    if (queue_.empty()) return closed_ ? std::nullopt : std::optional<std::string>(":\n\n");
    std::string text;
    for (const auto& event : std::exchange(queue_, {})) text += *event;
    return text;
  }

  void await_end(Time patience) {
    std::unique_lock lock(mutex_);
    changed_.wait_for(lock, patience, [this] { return closed_; });
  }

  void put(std::shared_ptr<const std::string> event) {
    if (waits_) return;
    {
      const std::scoped_lock lock(mutex_);
      if (queue_.size() >= most_queued) closed_ = true;  // the client reconnects
      if (!closed_) queue_.push_back(std::move(event));
    }
    changed_.notify_one();
  }
  void put(std::string event) { put(std::make_shared<const std::string>(std::move(event))); }

  void close() {
    {
      const std::scoped_lock lock(mutex_);
      closed_ = true;
    }
    changed_.notify_one();
  }

  [[nodiscard]] std::optional<JobId> job() const { return job_; }
  [[nodiscard]] bool waits() const { return waits_; }

  // Used by the thread of Events only.
  bool has_snapshot = false;  ///< the initial state was sent
  std::string latest;         ///< the latest event of its job

 private:
  const std::optional<JobId> job_;
  const bool waits_;
  std::mutex mutex_;  // guards queue_ and closed_
  std::deque<std::shared_ptr<const std::string>> queue_;
  bool closed_ = false;
  std::condition_variable changed_;
};

Events::Events(LoopClient& loop, std::size_t most_streams, Time between_polls)
    : loop_(loop),
      most_streams_(most_streams),
      between_polls_(between_polls),
      waits_("waits for jobs", {.inside = most_streams,
                                .one_inside = std::max<std::size_t>(1, most_streams * 3 / 4)}),
      thread_([this] { run(); }) {}

Events::~Events() {
  stop();
  thread_.join();
}

std::shared_ptr<BodyStream> Events::listen(std::optional<JobId> job) {
  const auto stream = std::make_shared<Stream>(job);
  {
    const std::scoped_lock lock(mutex_);
    const auto listens = [](const auto& weak) {
      const auto other = weak.lock();
      return other && !other->waits();
    };
    const auto listening = static_cast<std::size_t>(std::ranges::count_if(streams_, listens));
    if (stopped_) throw Problem(503, "the coordinator is stopping: try again later");
    if (listening >= most_streams_) {
      throw Problem(503,
                    "all " + std::to_string(most_streams_) +
                        " event streams are in use (--http-streams): try again later",
                    0, {{"Retry-After", "5"}});
    }
    add(stream);
  }
  changed_.notify_one();
  return stream;
}

/// Adds a listener. The caller holds mutex_.
void Events::add(const std::shared_ptr<Stream>& stream) {
  std::erase_if(streams_, [](const auto& other) { return other.expired(); });
  streams_.push_back(stream);
  ++joined_;
}

void Events::await_end(JobId job, const std::string& owner, Time patience) {
  const Places::Entry entry(waits_, owner);
  const auto stream = std::make_shared<Stream>(job, true);
  {
    const std::scoped_lock lock(mutex_);
    if (stopped_) return;
    add(stream);
  }
  changed_.notify_one();
  stream->await_end(patience);
}

void Events::forgotten(JobId job) {
  const std::scoped_lock lock(mutex_);
  if (!streams_.empty()) forgotten_.push_back(job);
}

void Events::stop() {
  {
    const std::scoped_lock lock(mutex_);
    stopped_ = true;
  }
  changed_.notify_one();
  for (const auto& stream : streams()) stream->close();
}

std::vector<std::shared_ptr<Events::Stream>> Events::streams() {
  std::vector<std::shared_ptr<Stream>> there;
  const std::scoped_lock lock(mutex_);
  for (const auto& weak : streams_) {
    if (auto stream = weak.lock()) there.push_back(std::move(stream));
  }
  return there;
}

void Events::run() {
  const SteadyClock clock;
  for (;;) {
    const Time begin = clock.now();
    const std::uint64_t served = joined_;
    poll();
    const Time rest = std::max<Time>(between_polls_, 50 * (clock.now() - begin));
    std::unique_lock lock(mutex_);
    const auto stopped = [this] { return stopped_; };
    // A new listener is served soon, but many new listeners cause at most four polls per second.
    constexpr auto least_rest = milliseconds(250);
    if (changed_.wait_for(lock, least_rest, stopped)) return;
    const auto news = [&] { return stopped_ || joined_ > served; };
    if (streams_.empty()) {
      changed_.wait(lock, news);
    } else {
      changed_.wait_for(lock, rest - least_rest, news);
    }
    if (stopped_) return;
  }
}

/// Sends the changes since the last poll. Without listeners, only drops what it knows.
void Events::poll() {
  std::vector<JobId> forgotten;
  {
    const std::scoped_lock lock(mutex_);
    forgotten = std::exchange(forgotten_, {});
    std::erase_if(streams_, [](const auto& stream) { return stream.expired(); });
  }
  for (const JobId job : forgotten) {
    jobs_.erase(job);
    send_to_all(forgotten_event(job));
  }
  std::vector<std::shared_ptr<Stream>> general;
  std::map<JobId, std::vector<std::shared_ptr<Stream>>> single;
  for (auto& stream : streams()) {
    (stream->job() ? single[*stream->job()] : general).push_back(std::move(stream));
  }
  try {
    for (const auto& [job, listening] : single) poll_single_job(job, listening);
    if (general.empty()) {
      jobs_.clear();
      workers_.clear();
      return;
    }
    poll_jobs();
    constexpr std::uint64_t polls_per_worker_poll = 3;
    if (polls_++ % polls_per_worker_poll == 0 || workers_.empty()) poll_workers();
    for (const auto& stream : general) {
      if (std::exchange(stream->has_snapshot, true)) continue;
      for (const auto& [id, announced] : jobs_) stream->put(announced.event);
      for (const auto& [name, announced] : workers_) stream->put(announced.event);
    }
  } catch (const Problem&) {
    // The loop is busy or stopping: the next poll sends the changes.
  }
}

/// Polls unfinished jobs, and jobs that have ended since the last poll.
void Events::poll_jobs() {
  for (auto& [id, announced] : jobs_) announced.seen = false;
  const json newest_jobs = loop_.ask<msg::Jobs>({}, msg::ListJobs{0, 0, newest}).jobs;
  for (const json& job : newest_jobs) update_job(job);
  JobId before = 0;
  for (std::size_t found = msg::most_listed; found == msg::most_listed;) {
    const json page =
        loop_.ask<msg::Jobs>({}, msg::ListJobs{0, before, msg::most_listed, unfinished}).jobs;
    for (const json& job : page) update_job(job);
    found = page.size();
    if (found > 0) before = page.front().at("id");
  }
  remove_unlisted(newest_jobs.empty() ? 0 : newest_jobs.front().at("id").get<JobId>());
}

void Events::update_job(const json& job) {
  Announced& announced = jobs_[job.at("id")];
  announced.ended = has_ended(job);
  announce(announced, event_text("job", job));
}

/// Records that a job or worker was found, and sends its event if it differs from the latest one.
void Events::announce(Announced& announced, std::string event) {
  announced.seen = true;
  if (event == announced.event) return;
  announced.event = std::move(event);
  send_to_all(announced.event);
}

/// Removes jobs that the last poll did not list, and sends their final event.
void Events::remove_unlisted(JobId oldest_listed) {
  std::erase_if(jobs_, [&](const auto& job) {
    const auto& [id, announced] = job;
    if (announced.seen) return false;
    try {
      if (!announced.ended || id >= oldest_listed) {
        send_to_all(event_text("job", loop_.ask<msg::Job>({}, msg::ShowJob{0, id}).job));
      }
    } catch (const Problem& problem) {
      if (problem.status() != 409) throw;
      send_to_all(forgotten_event(id));
    }
    return true;
  });
}

void Events::poll_workers() {
  for (auto& [name, announced] : workers_) announced.seen = false;
  std::uint64_t total = 1;
  for (std::uint32_t offset = 0; offset < total; offset += msg::most_listed) {
    const auto answer = loop_.ask<msg::Workers>({}, msg::ListWorkers{0, offset});
    total = answer.total;
    for (json worker : answer.workers) {
      round_times(worker);
      announce(workers_[worker.at("name")], event_text("worker", worker));
    }
  }
  std::erase_if(workers_, [this](const auto& worker) {
    if (!worker.second.seen) send_to_all(event_text("gone", {{"name", worker.first}}));
    return !worker.second.seen;
  });
}

/// Polls one job for its own listeners, and closes their streams when the job has ended.
void Events::poll_single_job(JobId job, const std::vector<std::shared_ptr<Stream>>& listening) {
  std::string event;
  bool last = true;
  try {
    const json shown = loop_.ask<msg::Job>({}, msg::ShowJob{0, job}).job;
    event = event_text("job", shown);
    last = has_ended(shown);
  } catch (const Problem& problem) {
    if (problem.status() != 409) throw;
    event = forgotten_event(job);
  }
  for (const auto& stream : listening) {
    if (event != stream->latest) stream->put(event);
    stream->latest = event;
    if (last) stream->close();
  }
}

/// Sends `event` to all general listeners that have the initial state.
void Events::send_to_all(const std::string& event) {
  const auto shared = std::make_shared<const std::string>(event);
  for (const auto& stream : streams()) {
    if (!stream->job() && stream->has_snapshot) stream->put(shared);
  }
}

}  // namespace parray::http
