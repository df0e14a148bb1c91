#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "coordinator/store/job_record.h"

namespace parray::coordinator {

/// Whose job the next lease is of.
///
/// Users take turns by what their leases cost in thread-seconds, each in proportion to a share,
/// however many jobs they have (stride scheduling: Waldspurger and Weihl, "Stride Scheduling",
/// MIT/LCS/TM-528, 1995). Who has no jobs for a while saves nothing up meanwhile.
///
/// Of one user the job of the highest priority goes first, then the oldest; but a quarter of what
/// the user gets goes to the job of that priority which has the least work left, in an **express
/// lane**, and there one that has had nothing yet is due at once: so a short job does not wait for
/// a long one that came before it.
///
/// No job starves: of what a user gets, a twentieth goes to those jobs that have waited in vain for
/// long, whatever their priority, to the one that has waited longest.
///
/// Plain state. One thread. A grant costs a time linear in the users at most.
class FairQueue {
 public:
  struct Entry {
    JobId id = 0;
    std::string user;
    double share = 1;  ///< > 0
    std::uint32_t priority = 0;
    bool fresh = false;     ///< has had no lease yet
    double work_left = 0;   ///< thread-seconds, roughly; only compared
    bool starving = false;  ///< has long had no turn by right
    double waited = 0;      ///< seconds since its latest lease, if it starves
  };

  /// The jobs that there are, by age. What users have had so far stays.
  void assign(const std::vector<Entry>& jobs);

  enum class Answer : std::uint8_t {
    granted,  ///< what the next charge() is for
    nothing,
    wait,  ///< nothing yet: the user's jobs behind it are not to overtake it
  };
  using Offer = std::function<Answer(JobId)>;
  /// Offers one job after the other, the most entitled first, until one is granted something.
  bool visit(const Offer& offer);

  /// Whether what visit() has granted was the job's turn by right, and not because it starves.
  [[nodiscard]] bool granted_by_turn() const { return lane_ != Lane::starving; }

  /// What visit() has granted takes so many thread-seconds.
  void charge(double thread_seconds);
  /// Adds thread-seconds to what a user has had; subtracts where negative. Call it when the real
  /// cost of a charged lease is known. Does nothing for users outside the queue.
  void correct(const std::string& user, double thread_seconds);

 private:
  struct User {
    std::string name;
    double share = 1;
    double had = 0;             ///< thread-seconds by share
    double owed = 0;            ///< thread-seconds that its express lane lacks of its part
    std::vector<JobId> jobs{};  ///< by priority, then age
    JobId shortest = 0;         ///< of the first's priority
    bool shortest_is_fresh = false;
    JobId starving = 0;        ///< the one that has waited longest; 0: none
    double owed_starving = 0;  ///< thread-seconds that those which starve lack of their part
  };
  enum class Lane : std::uint8_t { regular, express, starving };

  bool visit_user(User& user, const Offer& offer);

  std::vector<User> users_;    ///< with jobs; who has had the least comes first
  std::size_t granted_ = 0;    ///< whose lease the last was
  Lane lane_ = Lane::regular;  ///< by which it went
};

}  // namespace parray::coordinator
