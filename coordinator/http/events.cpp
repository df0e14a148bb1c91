#include "coordinator/http/events.h"

#include <cmath>
#include <nlohmann/json.hpp>
#include <utility>

namespace parray::http {
namespace {

using nlohmann::json;

constexpr const char* unfinished = "queued,running,paused,finishing";
constexpr std::uint32_t newest = 50;         ///< looked at whatever their state, for short ones
constexpr std::size_t most_waiting = 20000;  ///< events that a slow listener may be behind

std::string event_text(const char* name, const json& data) {
  return std::string("event: ") + name +
         "\ndata: " + data.dump(-1, ' ', false, json::error_handler_t::replace) + "\n\n";
}

bool has_ended(const json& job) {
  const std::string state = job.at("state");
  return state == "done" || state == "failed" || state == "cancelled";
}

std::string gone_text(JobId job) { return event_text("forgotten", {{"id", job}}); }

}  // namespace

/// A listener's queue.
class Events::Stream final : public EventStream {
 public:
  explicit Stream(std::optional<JobId> job) : job_(job) {}

  std::optional<std::string> next() override {
    constexpr auto most_silence = seconds(5);  // so that a connection that is gone is found out
    std::unique_lock lock(mutex_);
    changed_.wait_for(lock, most_silence, [this] { return closed_ || !queue_.empty(); });
    if (queue_.empty()) return closed_ ? std::nullopt : std::optional<std::string>(":\n\n");
    std::string text;
    for (const auto& event : std::exchange(queue_, {})) text += *event;
    return text;
  }

  void put(std::shared_ptr<const std::string> event) {
    {
      const std::scoped_lock lock(mutex_);
      if (queue_.size() >= most_waiting) closed_ = true;  // it connects again and gets all there is
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

  // The thread's own.
  bool knows_all = false;  ///< it has been told what there was when it came
  std::string told;        ///< the latest event of its job

 private:
  const std::optional<JobId> job_;
  std::mutex mutex_;  // guards the two below
  std::deque<std::shared_ptr<const std::string>> queue_;
  bool closed_ = false;
  std::condition_variable changed_;
};

Events::Events(LoopClient& loop, std::size_t most_streams)
    : loop_(loop), most_streams_(most_streams), thread_([this] { run(); }) {}

Events::~Events() {
  stop();
  thread_.join();
}

std::shared_ptr<EventStream> Events::listen(std::optional<JobId> job) {
  const auto stream = std::make_shared<Stream>(job);
  {
    const std::scoped_lock lock(mutex_);
    std::erase_if(streams_, [](const auto& other) { return other.expired(); });
    if (stopped_ || streams_.size() >= most_streams_) {
      throw Problem(503,
                    "all " + std::to_string(most_streams_) +
                        " event streams are taken (--http-streams): try again later",
                    0, {{"Retry-After", "5"}});
    }
    streams_.push_back(stream);
  }
  changed_.notify_one();
  return stream;
}

void Events::forgotten(JobId job) {
  const std::scoped_lock lock(mutex_);
  gone_.push_back(job);
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
    if (!streams().empty()) look();
    const Time rest = std::max<Time>(seconds(1), 50 * (clock.now() - begin));
    std::unique_lock lock(mutex_);
    const std::size_t listening = streams_.size();
    const auto stopped = [this] { return stopped_; };
    // Who comes is told soon, but a crowd does not make it look more than four times a second.
    constexpr auto least_rest = milliseconds(250);
    if (changed_.wait_for(lock, least_rest, stopped)) return;
    const auto news = [&] { return stopped_ || streams_.size() > listening; };
    if (listening == 0) {
      changed_.wait(lock, news);
    } else {
      changed_.wait_for(lock, rest - least_rest, news);
    }
    if (stopped_) return;
  }
}

void Events::look() {
  std::vector<JobId> gone;
  {
    const std::scoped_lock lock(mutex_);
    gone = std::exchange(gone_, {});
    std::erase_if(streams_, [](const auto& stream) { return stream.expired(); });
  }
  for (const JobId job : gone) {
    jobs_.erase(job);
    tell(gone_text(job));
  }
  std::vector<std::shared_ptr<Stream>> general;
  std::map<JobId, std::vector<std::shared_ptr<Stream>>> lone;
  for (auto& stream : streams()) {
    (stream->job() ? lone[*stream->job()] : general).push_back(std::move(stream));
  }
  try {
    for (const auto& [job, listening] : lone) look_at_lone(job, listening);
    if (general.empty()) {
      jobs_.clear();
      workers_.clear();
      return;
    }
    look_at_jobs();
    constexpr std::uint64_t worker_looks = 3;
    if (looks_++ % worker_looks == 0 || workers_.empty()) look_at_workers();
    for (const auto& stream : general) {
      if (std::exchange(stream->knows_all, true)) continue;
      for (const auto& [id, told] : jobs_) stream->put(told.event);
      for (const auto& [name, told] : workers_) stream->put(told.event);
    }
  } catch (const Problem&) {
    // The loop is busy or ending: the next look will tell.
  }
}

/// Those that are under way, and what has become of those that were.
void Events::look_at_jobs() {
  for (auto& [id, told] : jobs_) told.seen = false;
  const json newest_jobs = loop_.ask<msg::Jobs>({}, msg::ListJobs{0, 0, newest}).jobs;
  for (const json& job : newest_jobs) take_job(job);
  for (const json& job :
       loop_.ask<msg::Jobs>({}, msg::ListJobs{0, 0, msg::most_listed, unfinished}).jobs) {
    take_job(job);
  }
  lose_jobs(newest_jobs.empty() ? 0 : newest_jobs.front().at("id").get<JobId>());
}

void Events::take_job(const json& job) {
  const JobId id = job.at("id");
  std::string event = event_text("job", job);
  Told& told = jobs_[id];
  told.seen = true;
  told.ended = has_ended(job);
  if (event == told.event) return;
  told.event = std::move(event);
  tell(told.event);
}

/// Those that were listed before and are not now.
void Events::lose_jobs(JobId oldest_listed) {
  for (auto entry = jobs_.begin(); entry != jobs_.end();) {
    const auto& [id, told] = *entry;
    if (told.seen) {
      ++entry;
      continue;
    }
    try {
      if (!told.ended || id >= oldest_listed) {
        tell(event_text("job", loop_.ask<msg::Job>({}, msg::ShowJob{0, id}).job));
      }
    } catch (const Problem& problem) {
      if (problem.status() != 409) throw;
      tell(gone_text(id));
    }
    entry = jobs_.erase(entry);
  }
}

void Events::look_at_workers() {
  for (auto& [name, told] : workers_) told.seen = false;
  std::uint64_t total = 1;
  for (std::uint32_t offset = 0; offset < total; offset += msg::most_listed) {
    const auto answer = loop_.ask<msg::Workers>({}, msg::ListWorkers{0, offset});
    total = answer.total;
    for (json worker : answer.workers) {
      Told& told = workers_[worker.at("name")];
      told.seen = true;
      // That it was heard of again is no news.
      worker["seconds_silent"] = std::floor(worker.at("seconds_silent").get<double>() / 10) * 10;
      std::string event = event_text("worker", worker);
      if (event == told.event) continue;
      told.event = std::move(event);
      tell(told.event);
    }
  }
  for (auto entry = workers_.begin(); entry != workers_.end();) {
    if (!entry->second.seen) tell(event_text("gone", {{"name", entry->first}}));
    entry = entry->second.seen ? std::next(entry) : workers_.erase(entry);
  }
}

/// Of one job: until it has ended.
void Events::look_at_lone(JobId job, const std::vector<std::shared_ptr<Stream>>& listening) {
  std::string event;
  bool last = true;
  try {
    const json shown = loop_.ask<msg::Job>({}, msg::ShowJob{0, job}).job;
    event = event_text("job", shown);
    last = has_ended(shown);
  } catch (const Problem& problem) {
    if (problem.status() != 409) throw;
    event = gone_text(job);
  }
  for (const auto& stream : listening) {
    if (event != stream->told) stream->put(event);
    stream->told = event;
    if (last) stream->close();
  }
}

/// To those who know what there was before.
void Events::tell(const std::string& event) {
  const auto shared = std::make_shared<const std::string>(event);
  for (const auto& stream : streams()) {
    if (!stream->job() && stream->knows_all) stream->put(shared);
  }
}

}  // namespace parray::http
