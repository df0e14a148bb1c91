#include "coordinator/jobs/fair_queue.h"

#include <algorithm>
#include <map>
#include <tuple>
#include <utility>

namespace parray::coordinator {

void FairQueue::assign(const std::vector<Entry>& jobs) {
  std::map<std::string, std::vector<Entry>> by_user;
  for (const Entry& job : jobs) by_user[job.user].push_back(job);
  const double least = users_.empty() ? 0 : users_.front().had;
  std::map<std::string, User> known;
  for (User& user : users_) known.emplace(user.name, std::move(user));
  users_.clear();
  for (auto& [name, entries] : by_user) {
    std::ranges::stable_sort(
        entries, [](const Entry& a, const Entry& b) { return a.priority > b.priority; });
    const auto found = known.find(name);
    const bool is_new = found == known.end();
    User user{name, entries.front().share, is_new ? least : found->second.had,
              is_new ? 0 : found->second.owed};
    double longest = -1;
    for (const Entry& entry : entries) {
      if (entry.starving && entry.waited > longest) {
        longest = entry.waited;
        user.starving = entry.id;
      }
    }
    user.owed_starving = is_new || user.starving == 0 ? 0 : found->second.owed_starving;
    for (const Entry& entry : entries) user.jobs.push_back(entry.id);
    const auto shortest = std::ranges::min_element(entries, [](const Entry& a, const Entry& b) {
      return std::tuple(100 - a.priority, a.work_left) < std::tuple(100 - b.priority, b.work_left);
    });
    user.shortest = shortest->id;
    user.shortest_is_fresh = shortest->fresh;
    // A new user goes before users with the same total: none of its leases is being traced.
    const auto place = std::ranges::find_if(users_, [&](const User& other) {
      return is_new ? other.had >= user.had : other.had > user.had;
    });
    users_.insert(place, std::move(user));
  }
}

bool FairQueue::visit(const Offer& offer) {
  for (granted_ = 0; granted_ < users_.size(); ++granted_) {
    if (visit_user(users_[granted_], offer)) return true;
  }
  return false;
}

bool FairQueue::visit_user(User& user, const Offer& offer) {
  lane_ = Lane::starving;
  if (user.starving != 0 && user.owed_starving > 0) {
    if (offer(user.starving) == Answer::granted) return true;
    user.owed_starving = 0;  // it had its turn
  }
  if (user.shortest_is_fresh || user.owed > 0) {
    lane_ = Lane::express;
    if (offer(user.shortest) == Answer::granted) {
      user.shortest_is_fresh = false;
      return true;
    }
    user.owed = std::min(user.owed, 0.0);  // it had its turn
  }
  lane_ = Lane::regular;
  for (const JobId job : user.jobs) {
    const Answer answer = offer(job);
    if (answer != Answer::nothing) return answer == Answer::granted;
  }
  return false;
}

void FairQueue::charge(double thread_seconds) {
  User& user = users_[granted_];
  if (lane_ != Lane::starving) {
    user.owed += thread_seconds * (lane_ == Lane::express ? express_part - 1 : express_part);
  }
  if (user.starving != 0) {
    user.owed_starving +=
        thread_seconds * (lane_ == Lane::starving ? starving_part - 1 : starving_part);
  }
  user.had += thread_seconds / user.share;
  const auto begin = users_.begin() + static_cast<std::ptrdiff_t>(granted_);
  const auto end = std::find_if(begin + 1, users_.end(),
                                [&](const User& other) { return other.had > user.had; });
  std::rotate(begin, begin + 1, end);
}

void FairQueue::correct(const std::string& user, double thread_seconds) {
  const auto found = std::ranges::find(users_, user, &User::name);
  if (found != users_.end()) {
    found->had = std::max(0.0, found->had + thread_seconds / found->share);
    std::ranges::stable_sort(users_, {}, &User::had);
  }
}

}  // namespace parray::coordinator
