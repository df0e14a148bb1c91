#include <spdlog/spdlog.h>

#include <algorithm>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <utility>

#include "common/image/image.h"
#include "common/image/picture_bytes.h"
#include "common/scene/settings.h"
#include "coordinator/jobs/job_book.h"
#include "coordinator/jobs/picture_file.h"
#include "coordinator/loop/client_requests.h"
#include "coordinator/loop/farm.h"

namespace parray::coordinator {

using nlohmann::json;

static std::string no_picture_left(JobId id) {
  return fmt::format("the coordinator no longer keeps the picture of job {}: render it again", id);
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
  const Job* job = find_or_refuse(peer, m.request, m.job);
  if (job == nullptr) {
    return;
  }
  if (m.partial && !job->ended()) {
    send_partial(peer, m, *job);
  } else if (job->record.state != JobState::done) {
    farm_.fail_request(peer, m.request, 2,
                       "job " + std::to_string(m.job) + " is " +
                           std::string(name_of(job->record.state)) +
                           ", not done: parray watch shows its progress");
  } else {
    send_picture(peer, m, *job);
  }
}

/// Counts an answer of `bytes`. If there is no room now, sends an error and returns null.
BulkLedger::Ticket ClientRequests::admit_bulk(const PeerId& peer, std::uint64_t request,
                                              std::uint64_t bytes) {
  BulkLedger::Ticket ticket = farm_.bulk.admit(peer, bytes);
  if (!ticket) {
    farm_.send(peer,
               msg::Error{request, 2,
                          "too many pictures wait until their clients read them: read the pictures "
                          "that you requested, then try again",
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
  if (!ticket) {
    return;
  }
  const std::string doing = fmt::format("reading the picture of job {}", m.job);
  farm_.for_client(peer, m.request, doing)
      .give([this, answer, ticket, peer, store = farm_.store, id = m.job,
             report = job.record.report]() -> JobThread::Completion {
        const auto kept = std::make_shared<PictureFile>(read_picture_file(*store, id));
        if (kept->bytes) {
          answer->report = json::parse(report);
          kept->bytes->resize(std::min<std::size_t>(
              kept->bytes->size(),
              picture_size(answer->width, answer->height, detail_of(*answer))));
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
                },
                {}};
      });
}

/// Notes in the job's flag and history that its picture's file is damaged, or no longer damaged.
void ClientRequests::note_picture_file(JobId id, const PictureFile& kept) {
  Job* job = farm_.job_of(id);
  if (job == nullptr) {
    return;
  }
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

/// Sends the picture of an unfinished job as it is now.
void ClientRequests::send_partial(const PeerId& peer, const msg::Fetch& m, const Job& job) {
  if (!job.work || !job.work->plan) {
    farm_.fail_request(peer, m.request, 2,
                       "job " + std::to_string(m.job) + " has no picture yet: try again later");
    return;
  }
  // Without a store the client is in this process: the answer copies nothing and needs no limit.
  const RenderSettings& s = job.record.settings;
  const BulkLedger::Ticket ticket =
      farm_.store == nullptr
          ? nullptr
          : admit_bulk(peer, m.request, picture_size(s.width, s.height, PictureDetail::image));
  if (farm_.store != nullptr && !ticket) {
    return;
  }
  const std::string doing = fmt::format("reading the picture of job {}", m.job);
  farm_.for_client(peer, m.request, doing)
      .give([this, peer, ticket, request = m.request,
             run = job.work->run]() -> JobThread::Completion {
        auto parts = std::make_shared<PictureParts>();
        parts->image = shown_image(run->picture()).image;
        const json report = {{"partial", true},
                             {"samples", run->picture().framebuffer().counts().samples}};
        const auto answer = std::make_shared<msg::ImageData>(
            msg::ImageData{request, report, parts->image.width, parts->image.height, false, false,
                           PicturePayload(parts)});
        if (ticket) {
          Bulk bytes = answer->picture.bytes(PictureDetail::image);
          bytes.data = with_ticket(std::move(bytes.data), ticket);
          answer->picture = PicturePayload(std::move(bytes));
        }
        return {[this, answer, peer] { farm_.send(peer, std::move(*answer)); }, {}};
      });
}

/// Sends the journal: one line per merged lease, also of an unfinished job.
void ClientRequests::on(Time now, const PeerId& peer, msg::FetchJournal& m) {
  const Job* job = find_or_refuse(peer, m.request, m.job);
  if (job == nullptr) {
    return;
  }
  const auto answer = std::make_shared<msg::JournalData>();
  answer->request = m.request;
  answer->job = job_summary(*job, now, job_book_.waits_for(*job));
  const bool done = job->record.state == JobState::done;
  const RenderSettings& s = job->record.settings;
  const auto ticket = admit_bulk(peer, m.request, picture_size(s.width, s.height, kept_detail(s)));
  if (!ticket) {
    return;
  }
  const std::string doing = fmt::format("reading the journal of job {}", m.job);
  farm_.for_client(peer, m.request, doing)
      .give([this, answer, ticket, peer, done, store = farm_.store, id = m.job, kept = job->journal,
             report = job->record.report, size = picture_size(s.width, s.height, kept_detail(s)),
             run = job->work && job->work->plan ? job->work->run
                                                : nullptr]() -> JobThread::Completion {
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
                },
                {}};
      });
}

/// Sends the scene of a job to its owner, for denoising and labels. A worker gets scenes by
/// `need_scene`.
void ClientRequests::on(Time /*now*/, const PeerId& peer, msg::FetchScene& m) {
  const Job* job = find_or_refuse(peer, m.request, m.job);
  if (job == nullptr) return;
  const JobRecord& record = job->record;
  if (farm_.sender.role == Role::client && record.user != farm_.sender.name) {
    farm_.fail_request(peer, m.request, 2,
                       fmt::format("job {} belongs to {}, and only its owner gets its scene", m.job,
                                   record.user.empty() ? "another user" : "'" + record.user + "'"));
    return;
  }
  const std::string gone =
      fmt::format("the coordinator no longer keeps the scene of job {}: submit it again", m.job);
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
  farm_.for_client(peer, m.request, fmt::format("reading the scene of job {}", m.job))
      .give([this, answer, ticket, peer, gone, store = farm_.store,
             digest = record.scene]() -> JobThread::Completion {
        std::optional<std::string> bytes = store->scene(digest);
        const bool found = bytes.has_value();
        if (found) {
          answer->scene = ScenePayload(Bulk::of(with_ticket(*std::move(bytes), ticket)));
        }
        return {[this, answer, peer, gone, found] {
                  if (found) {
                    farm_.send(peer, std::move(*answer));
                  } else {
                    farm_.fail_request(peer, answer->request, 1, gone);
                  }
                },
                {}};
      });
}

}  // namespace parray::coordinator
