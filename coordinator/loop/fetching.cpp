#include <spdlog/spdlog.h>

#include <algorithm>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <utility>

#include "common/image/picture_bytes.h"
#include "common/scene/settings.h"
#include "coordinator/jobs/job_book.h"
#include "coordinator/jobs/picture_file.h"
#include "coordinator/loop/client_requests.h"

namespace parray::coordinator {

using nlohmann::json;

static std::string no_picture_left(JobId id) {
  return fmt::format(
      "the coordinator no longer keeps the picture of job {}: submit its scene again", id);
}

/// Returns why there is no complete picture, and what a client can do.
static std::string why_not_done(const Job& job) {
  const std::string state =
      fmt::format("job {} is {}, not done: ", job.record.id, name_of(job.record.state));
  if (!job.ended()) return state + "parray watch shows its progress";
  return state +
         (job.has_picture()
              ? fmt::format("parray fetch --partial {} -o FILE writes what it has", job.record.id)
              : fmt::format("parray requeue {} continues it", job.record.id));
}

/// Returns why a job has not even an incomplete picture.
static std::string why_no_partial(const Job& job) {
  return job.ended() ? fmt::format(
                           "job {} is {}, and no picture of it is kept: parray requeue {} "
                           "renders it",
                           job.record.id, name_of(job.record.state), job.record.id)
                     : fmt::format("job {} has no picture yet: try again later", job.record.id);
}

/// Returns the answer to a fetch, without the picture and its report.
static msg::ImageData answer_to(const msg::Fetch& m, const JobRecord& record) {
  const RenderSettings& s = record.settings;
  return {m.request,
          json::object(),
          s.width,
          s.height,
          m.statistics || m.replicates,
          m.replicates && s.replicates,
          {}};
}

void ClientRequests::on(Time /*now*/, const PeerId& peer, msg::Fetch& m) {
  if (farm_.bulk.serves(peer, m.request)) return;  // a repetition: the first one is being answered
  const Job* job = find_or_refuse(peer, m.request, m.job, true);
  if (job == nullptr) return;
  if (job->record.state == JobState::done) {
    send_picture(peer, m, *job);
  } else if (m.partial) {
    send_partial(peer, m, *job);
  } else {
    farm_.fail_request(peer, m.request, 2, why_not_done(*job));
  }
}

/// Counts an answer of `bytes`. If there is no room now, sends an error and returns null.
BulkLedger::Ticket ClientRequests::admit_bulk(const PeerId& peer, std::uint64_t request,
                                              std::uint64_t bytes) {
  BulkLedger::Ticket ticket = farm_.bulk.admit(peer, bytes, request);
  if (!ticket) {
    farm_.send(
        peer, msg::Error{request, 2,
                         "too many answers wait until their clients read them: read those that you "
                         "requested, or try again later",
                         true});
  }
  return ticket;
}

void ClientRequests::send_picture(const PeerId& peer, const msg::Fetch& m, const Job& job) {
  if (farm_.store != nullptr) {
    send_kept_picture(peer, m, job);
    return;
  }
  if (job.picture_bytes == 0) {
    farm_.fail_request(peer, m.request, 1, no_picture_left(m.job));
    return;
  }
  msg::ImageData answer = answer_to(m, job.record);
  answer.report = json::parse(job.record.report);
  answer.picture = job.picture;
  farm_.send(peer, std::move(answer));
}

void ClientRequests::send_kept_picture(const PeerId& peer, const msg::Fetch& m, const Job& job) {
  const auto answer = std::make_shared<msg::ImageData>(answer_to(m, job.record));
  const auto ticket =
      admit_bulk(peer, m.request, picture_size(answer->width, answer->height, detail_of(*answer)));
  if (!ticket) return;
  auto task = [this, answer, ticket, peer, store = farm_.store, id = m.job,
               report = job.record.report]() -> JobThread::Completion {
    const auto kept = std::make_shared<PictureFile>(read_picture_file(*store, id));
    if (kept->bytes) {
      answer->report = json::parse(report);
      kept->bytes->resize(std::min<std::size_t>(
          kept->bytes->size(), picture_size(answer->width, answer->height, detail_of(*answer))));
      answer->picture =
          PicturePayload(Bulk::of(with_ticket(std::exchange(*kept->bytes, {}), ticket)));
    }
    return {[this, answer, peer, kept, id] {
      note_picture_file(id, *kept);
      if (kept->bytes) {
        farm_.send(peer, std::move(*answer));
      } else {
        farm_.fail_request(peer, answer->request, 1,
                           kept->damage.empty() ? no_picture_left(id) : kept->damage);
      }
    }};
  };
  farm_.for_client(peer, m.request, fmt::format("reading the picture of job {}", m.job),
                   std::move(task));
}

/// Notes in the job's flag and history that its picture's file is damaged, or no longer damaged.
void ClientRequests::note_picture_file(JobId id, const PictureFile& kept) {
  Job* job = farm_.job_of(id);
  if (job == nullptr) return;
  if (!kept.damage.empty()) {
    farm_.warnings.warn(farm_.now, fmt::format("job {}: {}{}", id, kept.damage,
                                               kept.restored ? ": restored from the standby" : ""));
  }
  std::string flag = flag_with(job->record.flag, kept);
  if (flag != job->record.flag) {
    job->record.flag = std::move(flag);
    farm_.note(*job, job->record.flag.empty() ? "the file of its picture is readable again"
                                              : job->record.flag);
    farm_.keep(*job);
  }
}

/// Returns the answer with an incomplete picture, and counts its bytes under `ticket`.
static std::shared_ptr<msg::ImageData> partial_answer(const msg::Fetch& m,
                                                      const JobPicture& picture,
                                                      const BulkLedger::Ticket& ticket) {
  const auto parts = std::make_shared<PictureParts>(parts_so_far(picture, m.statistics));
  const json report = {{"partial", true}, {"samples", picture.framebuffer().counts().samples}};
  auto answer = std::make_shared<msg::ImageData>(
      msg::ImageData{m.request, report, parts->image.width, parts->image.height, m.statistics,
                     false, PicturePayload(parts)});
  if (ticket) {
    Bulk bytes = answer->picture.bytes(detail_of(*answer));
    bytes.data = with_ticket(std::move(bytes.data), ticket);
    answer->picture = PicturePayload(std::move(bytes));
  }
  return answer;
}

/// Sends the picture of a job that is not done, as it is now.
void ClientRequests::send_partial(const PeerId& peer, const msg::Fetch& m, const Job& job) {
  if (!job.has_picture()) {
    farm_.fail_request(peer, m.request, 2, why_no_partial(job));
    return;
  }
  if (!job.work && !job.stored) {
    msg::ImageData answer = answer_to(m, job.record);
    answer.statistics = m.statistics;  // `replicates` has an effect only for a done job
    answer.replicates = false;
    answer.report = {{"partial", true}, {"samples", job.samples()}};
    answer.picture = job.picture;
    farm_.send(peer, std::move(answer));
    return;
  }
  // Without a store the client is in this process: the answer copies nothing and needs no limit.
  const RenderSettings& s = job.record.settings;
  const PictureDetail detail = m.statistics ? PictureDetail::statistics : PictureDetail::image;
  const BulkLedger::Ticket ticket =
      farm_.store == nullptr ? nullptr
                             : admit_bulk(peer, m.request, picture_size(s.width, s.height, detail));
  if (farm_.store != nullptr && !ticket) return;
  if (!job.work) {
    send_from_log(peer, m, job, ticket);
    return;
  }
  auto task = [this, peer, ticket, m, run = job.work->run]() -> JobThread::Completion {
    const auto answer = partial_answer(m, run->picture(), ticket);
    return {[this, answer, peer] { farm_.send(peer, std::move(*answer)); }};
  };
  farm_.for_client(peer, m.request, fmt::format("reading the picture of job {}", m.job),
                   std::move(task));
}

/// Makes a run with the results of the job's log, up to the first damaged entry. Leaves the store
/// unchanged. But the run would write further results to `store`, so only read the run's picture.
/// Throws RunError if the store lacks the job's scene.
static JobRun run_from_log(Store& store, const JobRecord& record) {
  JobRun run(record, &store);
  const auto scene = store.scene(record.scene);
  if (!scene) throw RunError("the store lacks its scene");
  run.create_picture(SceneFacts(*ScenePayload(Bulk::of(*scene)).scene()), true,
                     [](const FramebufferView&) { return ErrorFigures{}; });
  run.replay(JobRun::OnDamage::stop);
  return run;
}

/// Sends the picture of a job that is not in memory, from its log. Makes one such picture at a
/// time.
void ClientRequests::send_from_log(const PeerId& peer, const msg::Fetch& m, const Job& job,
                                   const BulkLedger::Ticket& ticket) {
  if (farm_.log_pictures.serves(peer)) {
    return;  // clients repeat a request until it is answered
  }
  const std::uint64_t needed = job_book_.memory_of(job);
  const bool fits = job_book_.make_room(needed);
  const BulkLedger::Ticket memory = fits ? farm_.log_pictures.admit(peer, needed) : nullptr;
  if (!memory) {
    farm_.send(peer,
               msg::Error{m.request, 2,
                          fits ? "another picture is being read from its log: try again"
                               : "the coordinator's memory is full of other pictures: try again "
                                 "when a job has ended, or raise the coordinator's --memory",
                          true});
    return;
  }
  auto task = [this, peer, ticket, memory, m, store = farm_.store,
               record = job.record]() -> JobThread::Completion {
    JobRun run = run_from_log(*store, record);
    if (!run.picture().has_begun()) {
      throw RunError("its log has no results: " +
                     (is_unfinished(record.state)
                          ? std::string("try again when the job is traced again")
                          : "parray requeue " + std::to_string(record.id) + " renders it"));
    }
    const auto answer = partial_answer(m, run.picture(), ticket);
    return {[this, answer, peer] {
      farm_.grants_due = true;  // a job may wait for the memory
      farm_.send(peer, std::move(*answer));
    }};
  };
  farm_.for_client(peer, m.request, fmt::format("reading the results of job {}", m.job),
                   std::move(task));
}

/// Sends the journal: one line per merged lease, also of an unfinished job.
void ClientRequests::on(Time now, const PeerId& peer, msg::FetchJournal& m) {
  if (farm_.bulk.serves(peer, m.request)) return;
  const Job* job = find_or_refuse(peer, m.request, m.job);
  if (job == nullptr) return;
  const auto answer = std::make_shared<msg::JournalData>();
  answer->request = m.request;
  answer->job = job_book_.summary_of(now, *job);
  const bool done = job->record.state == JobState::done;
  const RenderSettings& s = job->record.settings;
  const auto ticket = admit_bulk(peer, m.request, picture_size(s.width, s.height, kept_detail(s)));
  if (!ticket) return;
  auto task =
      [this, answer, ticket, peer, done, store = farm_.store, id = m.job, kept = job->journal,
       report = job->record.report, size = picture_size(s.width, s.height, kept_detail(s)),
       run = job->work && job->work->plan ? job->work->run : nullptr]() -> JobThread::Completion {
    answer->report = report.empty() ? json::object() : json::parse(report);
    std::string bytes = kept;
    PictureFile file;
    if (run) {
      bytes = run->picture().journal().bytes();
    } else if (store != nullptr && done) {
      file = read_picture_file(*store, id);
      bytes = file.bytes && file.bytes->size() > size ? file.bytes->substr(size) : "";
      file.bytes = file.bytes ? std::optional(std::string()) : std::nullopt;
    }
    answer->journal = Bulk::of(with_ticket(std::move(bytes), ticket));
    return {[this, answer, peer, file, id] {
      note_picture_file(id, file);
      if (file.damage.empty() || file.restored) {
        farm_.send(peer, std::move(*answer));
      } else {
        farm_.fail_request(peer, answer->request, 1, file.damage);
      }
    }};
  };
  farm_.for_client(peer, m.request, fmt::format("reading the journal of job {}", m.job),
                   std::move(task));
}

/// Sends the scene of a job to its owner, for denoising and labels. A worker gets scenes by
/// `need_scene`.
void ClientRequests::on(Time /*now*/, const PeerId& peer, msg::FetchScene& m) {
  if (farm_.bulk.serves(peer, m.request)) return;
  const Job* job = find_or_refuse(peer, m.request, m.job);
  if (job == nullptr) return;
  const JobRecord& record = job->record;
  if (farm_.sender.role == Role::client && record.user != farm_.sender.name) {
    farm_.fail_request(
        peer, m.request, 2,
        fmt::format("job {} belongs to {}: only its owner and administrators get its scene", m.job,
                    record.user.empty() ? "another user" : "'" + record.user + "'"));
    return;
  }
  const std::string gone = fmt::format(
      "the coordinator no longer keeps the scene of job {}: submit the scene again", m.job);
  if (!store::needs_scene(record.state, record.keeps_scene()) ||
      (farm_.store == nullptr && job->scene.size() == 0)) {
    farm_.fail_request(peer, m.request, 2, gone);
    return;
  }
  const auto answer = std::make_shared<msg::SceneData>();
  answer->request = m.request;
  answer->settings = record.settings;
  answer->drawing = record.drawing;
  if (farm_.store == nullptr) {
    answer->scene = job->scene;
    farm_.send(peer, std::move(*answer));
    return;
  }
  const auto ticket = admit_bulk(peer, m.request, record.scene_bytes);
  if (!ticket) return;
  auto task = [this, answer, ticket, peer, gone, store = farm_.store,
               digest = record.scene]() -> JobThread::Completion {
    std::optional<std::string> bytes = store->scene(digest);
    const bool found = bytes.has_value();
    if (found) answer->scene = ScenePayload(Bulk::of(with_ticket(*std::move(bytes), ticket)));
    return {[this, answer, peer, gone, found] {
      if (found) {
        farm_.send(peer, std::move(*answer));
      } else {
        farm_.fail_request(peer, answer->request, 1, gone);
      }
    }};
  };
  farm_.for_client(peer, m.request, fmt::format("reading the scene of job {}", m.job),
                   std::move(task));
}

}  // namespace parray::coordinator
