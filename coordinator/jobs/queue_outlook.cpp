#include "coordinator/jobs/queue_outlook.h"

#include <algorithm>
#include <tuple>
#include <utility>

#include "coordinator/jobs/fair_queue.h"

namespace parray::coordinator {
namespace {

using Entry = QueueOutlook::Entry;

/// Stands for the thread-seconds of a job whose work is not known. Times beyond it are unknown.
constexpr double unknown_work = 1e15;

/// A job of one user, and when it begins in thread-seconds of this user.
struct Planned {
  const Entry* job = nullptr;
  double work = 0;
  double begins_after = -1;  ///< negative: not determined yet
  bool ended = false;
};

/// Determines when the jobs of one priority begin, which have the lanes of FairQueue: the regular
/// one goes through `jobs` by age, the express one by work. Returns when all are complete. `at`:
/// when the first begins.
double plan_priority(std::vector<Planned>& jobs, double at) {
  std::vector<Planned*> by_work;
  by_work.reserve(jobs.size());
  for (Planned& planned : jobs) by_work.push_back(&planned);
  std::ranges::stable_sort(by_work, {}, &Planned::work);
  std::size_t oldest = 0;
  std::size_t shortest = 0;
  for (;;) {
    while (oldest < jobs.size() && jobs[oldest].ended) ++oldest;
    while (shortest < by_work.size() && by_work[shortest]->ended) ++shortest;
    if (oldest == jobs.size()) return at;
    Planned& regular = jobs[oldest];
    Planned& express = *by_work[shortest];
    for (Planned* planned : {&regular, &express}) {
      if (planned->begins_after < 0) planned->begins_after = at;
    }
    if (&regular == &express) {
      at += std::exchange(regular.work, 0);
      regular.ended = true;
      continue;
    }
    const double step = std::min(regular.work / (1 - FairQueue::express_part),
                                 express.work / FairQueue::express_part);
    at += step;
    const bool regular_ends = regular.work / (1 - FairQueue::express_part) <= step;
    const bool express_ends = express.work / FairQueue::express_part <= step;
    regular.work = std::max(0.0, regular.work - step * (1 - FairQueue::express_part));
    express.work = std::max(0.0, express.work - step * FairQueue::express_part);
    regular.ended = regular_ends;
    express.ended = express_ends;
  }
}

/// All jobs of one user, by priority and age.
struct UserPlan {
  double share = 1;
  std::vector<Planned> jobs;
  double work = 0;  ///< thread-seconds of all jobs
};

void plan_user(UserPlan& user) {
  std::ranges::stable_sort(user.jobs, [](const Planned& a, const Planned& b) {
    return std::tuple(100 - a.job->priority, a.job->id) <
           std::tuple(100 - b.job->priority, b.job->id);
  });
  for (auto first = user.jobs.begin(); first != user.jobs.end();) {
    const auto end = std::find_if(first, user.jobs.end(), [&](const Planned& planned) {
      return planned.job->priority != first->job->priority;
    });
    std::vector<Planned> same(first, end);
    user.work = plan_priority(same, user.work);
    std::ranges::copy(same, first);
    first = end;
  }
}

/// Converts work of one user to time: users with work share the farm by their shares.
class SharedTime {
 public:
  /// `threads` > 0.
  SharedTime(const std::map<std::string, UserPlan>& users, double threads) {
    std::vector<std::pair<double, double>> ends;  // work per share, share
    double active = 0;
    for (const auto& [name, user] : users) {
      ends.emplace_back(user.work / user.share, user.share);
      active += user.share;
    }
    std::ranges::sort(ends);
    double had = 0;
    double time = 0;
    for (const auto& [end, share] : ends) {
      pieces_.push_back({had, time, active / threads});
      time += (end - had) * active / threads;
      had = end;
      active = std::max(0.0, active - share);
    }
  }

  /// Returns seconds from now until each user with work left has had `work_per_share`.
  [[nodiscard]] double at(double work_per_share) const {
    const auto next = std::ranges::upper_bound(pieces_, work_per_share, {}, &Piece::had);
    const Piece& piece = *std::prev(next);  // the first piece begins at 0
    return piece.time + (work_per_share - piece.had) * piece.slope;
  }

 private:
  struct Piece {
    double had;
    double time;
    double slope;
  };
  std::vector<Piece> pieces_;
};

struct Start {
  JobId id = 0;
  double at = 0;  ///< seconds
};

/// Applies the lane against starvation, which gives each starving job one lease in turn. `speed`:
/// thread-seconds per second of this user. `lease`: the most thread-seconds of one lease.
void start_starving(const UserPlan& user, double speed, double lease, std::vector<Start>& starts) {
  std::vector<std::pair<double, Start*>> waiting;  // when the job starves
  waiting.reserve(starts.size());
  std::map<JobId, const Entry*> jobs;
  for (const Planned& planned : user.jobs) jobs.emplace(planned.job->id, planned.job);
  for (Start& start : starts) waiting.emplace_back(jobs.at(start.id)->until_starving, &start);
  std::ranges::stable_sort(waiting, {}, &std::pair<double, Start*>::first);
  double free_at = 0;
  for (const auto& [starves_at, start] : waiting) {
    const double at = std::max(starves_at, free_at);
    if (start->at <= at) continue;  // it begins by a regular turn
    start->at = at;
    const Entry& job = *jobs.at(start->id);
    free_at = at + std::min(job.work_left, lease) / (FairQueue::starving_part * speed);
  }
}

}  // namespace

void QueueOutlook::assign(const std::vector<Entry>& jobs, double threads, double lease_seconds) {
  places_.clear();
  std::map<std::string, UserPlan> users;
  double shares = 0;
  for (const Entry& job : jobs) {
    UserPlan& user = users[job.user];
    user.share = job.share;
    user.jobs.push_back({&job, job.work_known ? job.work_left : job.work_left + unknown_work});
  }
  for (auto& [name, user] : users) {
    plan_user(user);
    shares += user.share;
  }
  const bool known = threads > 0;
  const double speed = known ? threads : 1;
  const SharedTime time(users, speed);
  std::vector<Start> all;
  for (const auto& [name, user] : users) {
    const Entry& head = *user.jobs.front().job;
    std::vector<Start> starts;
    for (const Planned& planned : user.jobs) {
      const Entry& job = *planned.job;
      if (job.begun) continue;
      const bool first = &job == &head || planned.begins_after == 0;
      places_[job.id] = {0, first ? 0 : head.id, first ? 0 : head.priority, {}};
      starts.push_back({job.id, time.at(planned.begins_after / user.share)});
    }
    start_starving(user, speed * user.share / shares, lease_seconds * speed, starts);
    all.insert(all.end(), starts.begin(), starts.end());
  }
  std::ranges::stable_sort(all, [](const Start& a, const Start& b) {
    return std::tuple(a.at, a.id) < std::tuple(b.at, b.id);
  });
  std::uint32_t number = 0;
  for (const Start& start : all) {
    Place& place = places_.at(start.id);
    place.number = ++number;
    if (known && start.at < unknown_work / (1e3 * speed)) place.starts_in = start.at;
  }
}

const QueueOutlook::Place* QueueOutlook::of(JobId id) const {
  const auto found = places_.find(id);
  return found == places_.end() ? nullptr : &found->second;
}

}  // namespace parray::coordinator
