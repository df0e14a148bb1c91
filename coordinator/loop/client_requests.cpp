// Shows and changes jobs as clients request: one job, a series, or many at once.
#include "coordinator/loop/client_requests.h"

#include <spdlog/fmt/fmt.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include "common/base/error.h"
#include "common/base/printable.h"
#include "coordinator/jobs/job_book.h"
#include "coordinator/jobs/job_list.h"
#include "coordinator/loop/worker_desk.h"

namespace parray::coordinator {

using nlohmann::json;

namespace {

/// A job that stays as it is, and why.
class Refused : public InputError {
 public:
  Refused(msg::Refusal why, const std::string& message) : InputError(message), why_(why) {}
  [[nodiscard]] msg::Refusal why() const { return why_; }

 private:
  msg::Refusal why_;
};

/// Returns a text that differs for different requests.
std::string content_of(const Sender& sender, const auto& m, const std::vector<JobId>& jobs) {
  std::string text =
      fmt::format("{} {} {} {}", m.request, static_cast<int>(m.action), m.priority, sender.name);
  for (const JobId job : jobs) text += " " + std::to_string(job);
  return text;
}

}  // namespace

void ClientRequests::on(Time now, const PeerId& peer, msg::ListJobs& m) {
  const JobList found = list_of(farm_.index, m, now);
  auto list = json::array();
  for (const JobIndex::Frames* frames : found.page) {
    list.push_back(short_map(job_book_.summary_of(now, series_of(*frames)), found.page.size()));
  }
  farm_.send(peer, msg::Jobs{m.request, std::move(list), found.total});
}

std::string ClientRequests::no_job_text(JobId id, bool picture) const {
  return job_book_.frames_of(id).empty()
             ? fmt::format("no job {}: parray jobs lists all jobs", id)
             : fmt::format(
                   "{} is a series of frames: {}name the job of one frame (parray show {} lists "
                   "them)",
                   id, picture ? "write #### in the picture's name, or " : "", id);
}

/// Finds a job. If there is none, sends an error and returns null. `picture`: the request is a
/// fetch.
Job* ClientRequests::find_or_refuse(const PeerId& peer, std::uint64_t request, JobId id,
                                    bool picture) {
  Job* job = farm_.job_of(id);
  if (job == nullptr) farm_.fail_request(peer, request, 2, no_job_text(id, picture));
  return job;
}

void ClientRequests::on(Time now, const PeerId& peer, msg::ShowJob& m) {
  const std::vector<Job*> frames = job_book_.frames_of(m.job);
  if (!frames.empty()) {
    const Series series(frames.begin(), frames.end());
    json summary = job_book_.summary_of(now, series);
    summary["frame_list"] = frame_list(series, now, m.from_frame);
    summary["events"] = events_to_json(events_of(series));
    farm_.send(peer, msg::Job{m.request, std::move(summary)});
  } else if (const Job* job = find_or_refuse(peer, m.request, m.job)) {
    json summary = job_book_.summary_of(now, *job);
    summary["events"] = events_to_json(job->record.events);
    summary["passes"] = curve_to_json(job->record.course.curve);
    farm_.send(peer, msg::Job{m.request, std::move(summary)});
  }
}

/// Finds a job, or all frames of a series. Throws Refused if there is none, or if the sender may
/// not change it.
std::vector<Job*> ClientRequests::find_changeable(JobId id) {
  std::vector<Job*> jobs = job_book_.frames_of(id);
  if (jobs.empty()) {
    Job* job = farm_.job_of(id);
    if (job == nullptr) throw Refused(msg::Refusal::missing, no_job_text(id));
    jobs = {job};
  }
  const std::string& user = jobs.front()->record.user;
  if (farm_.sender.role == Role::client && user != farm_.sender.name) {
    throw Refused(msg::Refusal::forbidden, "job " + std::to_string(id) + " belongs to " +
                                               (user.empty() ? "no user" : "'" + user + "'") +
                                               ", not to '" + farm_.sender.name +
                                               "': ask its owner or an administrator");
  }
  return jobs;
}

/// Throws NoRoom or InputError if there is no room to queue the jobs again.
void ClientRequests::check_room_to_requeue(const Series& named) {
  const auto again = std::ranges::find_if(
      named, [](const Job* job) { return job->ended() && job->record.state != JobState::done; });
  if (again != named.end()) {
    JobRecord record = (*again)->record;
    record.scene_bytes = 0;  // the store's count of bytes contains its scene
    job_book_.check_limits(record);
  }
}

/// Changes a job or a series and returns its map. Throws Refused, InputError.
json ClientRequests::steer(Time now, const msg::SteerJob& m) {
  const std::vector<Job*> jobs = find_changeable(m.job);
  const Series named(jobs.begin(), jobs.end());
  if (m.action == msg::JobAction::requeue) {
    try {
      check_room_to_requeue(named);
    } catch (const InputError& error) {
      throw Refused(msg::Refusal::no_room, error.what());
    }
  }
  const bool whole_series = jobs.front()->record.id != m.job;
  std::string misfit;
  std::size_t misfits = 0;
  for (Job* job : jobs) {
    try {
      job_book_.steer(*job, m);
    } catch (const InputError& error) {  // this frame of a series stays as it is
      misfit = misfit.empty() ? error.what() : misfit;
      ++misfits;
    }
  }
  const bool forget = m.action == msg::JobAction::forget;
  if (misfits == jobs.size() || (forget && misfits > 0)) {
    throw Refused(msg::Refusal::state, whole_series && jobs.size() > 1
                                           ? fmt::format("series {}: {}", m.job, misfit)
                                           : misfit);
  }
  for (const Job* job : named) {
    if (job->ended()) worker_desk_.forget_scene(job->record.scene);
  }
  json summary =
      whole_series ? job_book_.summary_of(now, named) : job_book_.summary_of(now, *jobs.front());
  if (forget) {
    const std::string why = "as " + job_book_.asker() + " requested";
    whole_series ? job_book_.forget_all(named, why) : job_book_.forget_job(m.job, why);
  }
  return summary;
}

void ClientRequests::note_steered() {
  job_book_.list_open_jobs();
  job_book_.make_room(0);
}

/// Sends the answer again if the latest request of the peer had the same content. The answer to a
/// change that the store cannot commit now is an error. False: the content was another one.
bool ClientRequests::repeat_answer(const PeerId& peer, std::uint64_t request,
                                   const std::string& content) {
  const auto found = std::ranges::find(answers_, peer, &Answered::peer);
  if (found == answers_.end() || found->content != content) return false;
  if (found->answer) {
    farm_.send(peer, *found->answer);
  } else if (!farm_.storage.empty()) {
    farm_.fail_request(peer, request, 1,
                       "the change is made, but not stored yet (" + farm_.storage +
                           "): if the coordinator ends before it has stored the change, the change "
                           "is lost");
  }
  return true;
}

/// Sends the answer when the store has committed what the request changed: nothing that a client
/// knows may be lost.
void ClientRequests::answer_once(const PeerId& peer, const std::string& content, Message answer) {
  constexpr std::size_t most = 32;
  std::erase_if(answers_, [&](const Answered& earlier) { return earlier.peer == peer; });
  if (answers_.size() == most) answers_.pop_front();
  answers_.push_back({peer, content, {}});
  farm_.when_kept([this, peer, content, answer = std::move(answer)] {
    const auto found = std::ranges::find(answers_, peer, &Answered::peer);
    if (found != answers_.end() && found->content == content) found->answer = answer;
    farm_.send(peer, answer);
  });
}

void ClientRequests::on(Time now, const PeerId& peer, msg::SteerJob& m) {
  const std::string content = content_of(farm_.sender, m, {m.job});
  if (repeat_answer(peer, m.request, content)) return;
  try {
    json summary = steer(now, m);
    answer_once(peer, content, msg::Job{m.request, std::move(summary)});
  } catch (const InputError& error) {
    farm_.fail_request(peer, m.request, 2, error.what());
  }
  note_steered();
}

void ClientRequests::on(Time now, const PeerId& peer, msg::SteerJobs& m) {
  const std::string content = content_of(farm_.sender, m, m.jobs);
  if (repeat_answer(peer, m.request, content)) return;
  json results = json::array();
  for (const JobId id : m.jobs) {
    try {
      json job = short_map(steer(now, {m.request, id, m.action, m.priority}), m.jobs.size());
      results.push_back({{"id", id}, {"job", std::move(job)}});
    } catch (const Refused& refused) {
      constexpr std::size_t longest = 400;
      results.push_back({{"id", id},
                         {"refusal", refusal_names[static_cast<std::size_t>(refused.why())]},
                         {"message", printable(refused.what(), longest)}});
    }
  }
  answer_once(peer, content, msg::Steered{m.request, std::move(results)});
  note_steered();
}

}  // namespace parray::coordinator
