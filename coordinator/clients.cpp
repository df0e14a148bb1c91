// What the coordinator answers to clients.
#include <spdlog/spdlog.h>

#include <algorithm>
#include <iterator>

#include "common/base/bytes.h"
#include "common/base/error.h"
#include "common/scene/scene_bytes.h"
#include "coordinator/coordinator.h"

namespace parray {

using nlohmann::json;

namespace {

/// Entries of a list: with names of the longest kind they still fit a control frame.
constexpr std::size_t most_listed = 1000;

}  // namespace

void Coordinator::fail_request(const PeerId& peer, std::uint64_t request, std::uint32_t status,
                               const std::string& message) {
  send(peer, msg::Error{request, status, message});
}

void Coordinator::on(Time /*now*/, const PeerId& peer, msg::Submit& m) {
  for (const auto& [id, job] : jobs_) {
    if (job.record.token == m.token) {  // a repeated submit is the same job
      send(peer, msg::Submitted{m.request, id});
      return;
    }
  }
  try {
    make_room_for_job();
    Job job;
    job.record.id = next_job_;
    job.record.token = m.token;
    job.record.name = m.name;
    job.record.priority = m.priority;
    job.record.settings = m.settings;
    job.record.precision_reason = m.precision_reason;
    job.record.duplicates_removed = m.duplicates_removed;
    job.record.load_seconds = m.load_seconds;
    job.record.scene = scene_identity(m.scene_bytes);
    job.start_work(std::make_shared<const std::string>(std::move(m.scene_bytes)));
    store_.put_scene(job.record.scene, *job.work->scene_bytes);
    store_.put_job(job.record);
    store_dirty_ = true;
    ++next_job_;
    log_->info("job {} '{}' submitted: {} spheres, {} x {} pixels, {} samples", job.record.id,
               job.record.name, job.work->requirements.spheres, m.settings.width, m.settings.height,
               m.settings.samples_per_pixel);
    send(peer, msg::Submitted{m.request, job.record.id});
    jobs_.emplace(job.record.id, std::move(job));
    sort_open_jobs();
  } catch (const InputError& error) {
    fail_request(peer, m.request, 2, error.what());
  } catch (const DecodeError& error) {
    fail_request(peer, m.request, 2, error.what());
  }
}

void Coordinator::on(Time now, const PeerId& peer, msg::ListJobs& m) {
  auto list = json::array();
  const std::size_t skipped = jobs_.size() - std::min(jobs_.size(), most_listed);
  for (auto job = std::next(jobs_.begin(), static_cast<std::ptrdiff_t>(skipped));
       job != jobs_.end(); ++job) {
    list.push_back(job_summary(job->second, now));
  }
  send(peer, msg::Jobs{m.request, std::move(list)});
}

void Coordinator::on(Time now, const PeerId& peer, msg::ShowJob& m) {
  if (const Job* job = job_of(m.job)) {
    send(peer, msg::Job{m.request, job_summary(*job, now)});
  } else {
    fail_request(peer, m.request, 2, "no job " + std::to_string(m.job) + ": see parray jobs");
  }
}

void Coordinator::on(Time now, const PeerId& peer, msg::Cancel& m) {
  Job* job = job_of(m.job);
  if (job == nullptr) {
    fail_request(peer, m.request, 2, "no job " + std::to_string(m.job) + ": see parray jobs");
    return;
  }
  if (job->open()) {
    close_job(*job, JobState::cancelled, "cancelled by a client");  // heartbeats revoke its leases
  }
  send(peer, msg::Job{m.request, job_summary(*job, now)});
}

void Coordinator::on(Time /*now*/, const PeerId& peer, msg::Fetch& m) {
  const Job* job = job_of(m.job);
  if (job == nullptr) {
    fail_request(peer, m.request, 2, "no job " + std::to_string(m.job) + ": see parray jobs");
    return;
  }
  if (m.partial && job->open()) {
    send_partial(peer, m, *job);
    return;
  }
  if (job->record.state != JobState::done) {
    fail_request(peer, m.request, 2,
                 "job " + std::to_string(m.job) + " is " + std::string(name_of(job->record.state)) +
                     ", not done: see parray watch");
    return;
  }
  auto picture = store_.picture(m.job);
  if (!picture) {
    fail_request(peer, m.request, 1,
                 "the picture of job " + std::to_string(m.job) + " is no longer kept");
    return;
  }
  const RenderSettings& s = job->record.settings;
  if (!m.statistics) {
    picture->resize(std::min<std::size_t>(picture->size(), picture_size(s.width, s.height, false)));
  }
  send(peer, msg::ImageData{m.request, json::parse(job->record.report), s.width, s.height,
                            m.statistics, std::move(*picture)});
}

/// What there is of a picture, for those who cannot wait.
void Coordinator::send_partial(const PeerId& peer, const msg::Fetch& m, const Job& job) {
  const Image image = resolve_image(job.work->framebuffer, job.work->largest_radiance);
  const json report = {{"partial", true}, {"samples", job.work->framebuffer.counts().samples}};
  send(peer, msg::ImageData{m.request, report, image.width, image.height, false,
                            picture_to_bytes(image, {})});
}

void Coordinator::on(Time now, const PeerId& peer, msg::ListWorkers& m) {
  auto list = json::array();
  for (const auto& [id, worker] : workers_) {
    if (list.size() == most_listed) {
      break;
    }
    std::size_t leases = 0;
    for (const Job* job : open_jobs_) {
      leases += job->work->leases.held_by(worker.id);
    }
    list.push_back({{"name", worker.hello.name},
                    {"threads", worker.hello.threads},
                    {"leases", leases},
                    {"accepted", worker.accepted},
                    {"samples_per_second", worker.samples_per_second},
                    {"state", worker.quarantined ? "quarantined" : "ready"},
                    {"seconds_silent", to_seconds(now - worker.last_heard)}});
  }
  send(peer, msg::Workers{m.request, std::move(list)});
}

}  // namespace parray
