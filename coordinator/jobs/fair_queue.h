#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "coordinator/store/job_record.h"

namespace parray::coordinator {

/// Decides which job gets the next lease.
///
/// Users take turns by the thread-seconds of their leases, in proportion to their shares, however
/// many jobs they have (stride scheduling: Waldspurger and Weihl, "Stride Scheduling",
/// MIT/LCS/TM-528, 1995). A user does not accumulate credit while having no jobs.
///
/// Among the jobs of one user, the highest priority goes first, then the oldest job. However, a
/// quarter of the user's time goes to an **express lane**: of the jobs of the highest priority, the
/// one with the least work left. If it has had no lease yet, its turn is next. So a short job does
/// not wait for a long one that came earlier. Jobs of a lower priority have no express lane.
///
/// No job starves: a twentieth of a user's time goes to jobs that have waited long, whatever their
/// priority. The job that has waited longest gets it.
///
/// Not thread-safe. A grant takes at most linear time in the numbers of users and of jobs.
class FairQueue {
 public:
  /// Part of a user's time that goes to the express lane.
  static constexpr double express_part = 0.25;
  /// Part of a user's time that goes to starving jobs.
  static constexpr double starving_part = 0.05;
  /// Seconds without a lease by a regular or express turn after which a job starves. They count
  /// from its latest such lease, or from when it began to wait.
  static constexpr double starving_after = 600;

  /// A job that needs leases.
  struct Entry {
    JobId id = 0;
    std::string user;
    double share = 1;  ///< > 0
    std::uint32_t priority = 0;
    bool fresh = false;     ///< neither it nor another frame of its series has had a lease yet
    double work_left = 0;   ///< thread-seconds of its series, roughly; only for comparisons
    bool starving = false;  ///< no regular or express turn for starving_after
    /// Seconds since its latest lease, or since it began to wait. Read only if it starves.
    double waited = 0;
  };

  /// Replaces the jobs; `jobs` must be sorted by age, the oldest first. A user with jobs before and
  /// after the call keeps its total of thread-seconds. A new user begins with the least total of
  /// all users.
  void assign(const std::vector<Entry>& jobs);

  enum class Answer : std::uint8_t {
    granted,  ///< the job got a lease; charge() must follow
    nothing,  ///< the job needs no lease now
    wait,     ///< nothing yet, and later jobs of this user must not overtake it
  };
  using Offer = std::function<Answer(JobId)>;
  /// Calls `offer` for one job after the other in the order of their turns, until one is granted a
  /// lease. Returns whether one was.
  bool visit(const Offer& offer);

  /// Returns whether visit() selected the job by a regular or express turn, not because it starves.
  [[nodiscard]] bool granted_by_turn() const { return lane_ != Lane::starving; }

  /// Charges the user of the job that visit() selected for these thread-seconds.
  void charge(double thread_seconds);
  /// Adds thread-seconds, which may be negative, to a user's total. Call it when the real cost of a
  /// charged lease is known. Does nothing for users without jobs in the queue.
  void correct(const std::string& user, double thread_seconds);

 private:
  struct User {
    std::string name;
    double share = 1;
    double had = 0;             ///< thread-seconds so far, divided by the share
    double owed = 0;            ///< thread-seconds that the express lane should still get
    std::vector<JobId> jobs{};  ///< by priority, then age
    JobId shortest = 0;         ///< the job with the least work left of the highest priority
    bool shortest_is_fresh = false;
    JobId starving = 0;        ///< the starving job that has waited longest; 0: none
    double owed_starving = 0;  ///< thread-seconds that starving jobs should still get
  };
  enum class Lane : std::uint8_t { regular, express, starving };

  bool visit_user(User& user, const Offer& offer);

  std::vector<User> users_;    ///< users with jobs; the one that has had the least comes first
  std::size_t granted_ = 0;    ///< index of the user of the last grant
  Lane lane_ = Lane::regular;  ///< lane of the last grant
};

}  // namespace parray::coordinator
