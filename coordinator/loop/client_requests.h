#pragma once

#include <cstdint>
#include <deque>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <vector>

#include "coordinator/jobs/series.h"
#include "coordinator/loop/farm.h"

namespace parray::coordinator {

class DisputeDesk;
class JobBook;
class LeaseDesk;
class WorkerDesk;
struct PictureFile;

/// Answers all requests of clients except `submit` (JobBook) and `show_log` (WorkerLogs). Checks
/// who may make a change.
class ClientRequests {
 public:
  ClientRequests(Farm& farm, JobBook& job_book, LeaseDesk& leases, DisputeDesk& disputes,
                 WorkerDesk& worker_desk)
      : farm_(farm),
        job_book_(job_book),
        leases_(leases),
        disputes_(disputes),
        worker_desk_(worker_desk) {}

  /// Handle the requests of PROTOCOL.md. Each request gets one answer, which may be an error. A
  /// fetch that is repeated before its answer has left gets no second answer.
  void on(Time now, const PeerId& peer, msg::ListJobs& m);
  void on(Time now, const PeerId& peer, msg::ShowJob& m);
  void on(Time now, const PeerId& peer, msg::Fetch& m);
  void on(Time now, const PeerId& peer, msg::FetchJournal& m);
  void on(Time now, const PeerId& peer, msg::FetchScene& m);
  void on(Time now, const PeerId& peer, msg::ListWorkers& m);
  void on(Time now, const PeerId& peer, msg::ShowWorker& m);
  void on(Time now, const PeerId& peer, msg::ShowFarm& m);
  void on(Time now, const PeerId& peer, msg::SteerWorkers& m);
  /// Change jobs. The answer follows when the store has committed the changes. A client repeats a
  /// request whose answer was lost. If that is the latest such request of its peer, the client gets
  /// the first answer again, and the jobs do not change a second time. This holds for the latest 32
  /// peers.
  void on(Time now, const PeerId& peer, msg::SteerJob& m);
  void on(Time now, const PeerId& peer, msg::SteerJobs& m);

 private:
  [[nodiscard]] nlohmann::json farm_map(Time now);
  Job* find_or_refuse(const PeerId& peer, std::uint64_t request, JobId id, bool picture = false);
  [[nodiscard]] std::string no_job_text(JobId id, bool picture = false) const;
  std::vector<Job*> find_changeable(JobId id);
  void check_room_to_requeue(const Series& named);
  nlohmann::json steer(Time now, const msg::SteerJob& m);
  void note_steered();
  bool repeat_answer(const PeerId& peer, std::uint64_t request, const std::string& content);
  void answer_once(const PeerId& peer, const std::string& content, Message answer);
  void readmit(Time now, const msg::SteerWorkers& m);
  BulkLedger::Ticket admit_bulk(const PeerId& peer, std::uint64_t request, std::uint64_t bytes);
  void send_picture(const PeerId& peer, const msg::Fetch& m, const Job& job);
  void send_kept_picture(const PeerId& peer, const msg::Fetch& m, const Job& job);
  void send_partial(const PeerId& peer, const msg::Fetch& m, const Job& job);
  void send_from_log(const PeerId& peer, const msg::Fetch& m, const Job& job,
                     const BulkLedger::Ticket& ticket);
  void note_picture_file(JobId id, const PictureFile& kept);

  /// The latest change of jobs that a peer requested.
  struct Answered {
    PeerId peer;
    std::string content;            ///< identifies the request
    std::optional<Message> answer;  ///< nothing: the store has not committed the changes yet
  };

  Farm& farm_;
  JobBook& job_book_;
  LeaseDesk& leases_;
  DisputeDesk& disputes_;
  WorkerDesk& worker_desk_;
  std::deque<Answered> answers_;  ///< the latest 32, at most one of each peer
};

}  // namespace parray::coordinator
