#include "coordinator/job.h"

#include <algorithm>
#include <array>
#include <utility>

#include "common/base/error.h"
#include "common/scene/scene_bytes.h"
#include "common/trace/kernel.h"

namespace parray {

using nlohmann::json;

/// Pixels with samples that were not finite, in the report: enough to find the cause.
static constexpr std::size_t most_located = 20;

std::string_view name_of(JobState state) {
  constexpr std::array<std::string_view, 6> names = {"queued", "running", "paused",
                                                     "done",   "failed",  "cancelled"};
  return names[static_cast<std::size_t>(state)];
}

void Job::start_work(std::shared_ptr<const std::string> scene_bytes) {
  const Scene scene = scene_from_bytes(*scene_bytes);
  auto fresh = std::make_unique<JobWork>(record.settings, first_epoch());
  fresh->requirements = requirements_of(scene);
  fresh->largest_radiance = largest_radiance(scene);
  fresh->scene_bytes = std::move(scene_bytes);
  work = std::move(fresh);
}

void Job::take_up(Store& store) {
  auto scene = store.scene(record.scene);
  if (!scene) {
    throw RunError("its scene is missing");
  }
  ++record.life;
  record.state = JobState::queued;
  store.put_job(record);
  start_work(std::make_shared<const std::string>(std::move(*scene)));
  store.each_block(record.id, [&](const std::string& bytes) {
    const RowBlock block = row_block_from_bytes(bytes);
    work->leases.restore(block.rect);
    work->framebuffer.merge(block);
  });
}

json job_summary(const Job& job, Time now) {
  const JobRecord& record = job.record;
  json summary = {{"id", record.id},
                  {"name", record.name},
                  {"state", name_of(record.state)},
                  {"priority", record.priority},
                  {"progress", record.state == JobState::done ? 1.0 : 0.0},
                  {"samples_per_second", 0.0},
                  {"seconds_left", -1.0},
                  {"reason", record.reason},
                  {"width", record.settings.width},
                  {"height", record.settings.height},
                  {"samples_per_pixel", record.settings.samples_per_pixel},
                  {"sampler", name_of(record.settings.sampler)}};
  if (!job.open()) {
    return summary;
  }
  const JobWork& work = *job.work;
  summary["progress"] = work.leases.progress();
  if (work.started != never && now > work.started && work.leases.done_units() > 0) {
    const double per_second =
        static_cast<double>(work.leases.done_units()) / to_seconds(now - work.started);
    const auto left = static_cast<double>(work.leases.total_units() - work.leases.done_units());
    summary["samples_per_second"] = per_second * record.settings.width;
    summary["seconds_left"] = left / per_second;
  }
  return summary;
}

json make_report(const Job& job, const std::string& image_sha256, Time finished) {
  const RenderSettings& s = job.record.settings;
  const JobWork& work = *job.work;
  const TraceCounts& counts = work.framebuffer.counts();
  json located = json::array();
  for (const auto& [pixel, excluded] : work.framebuffer.excluded()) {
    if (located.size() == most_located) {
      break;
    }
    located.push_back({{"x", pixel.second},
                       {"y", pixel.first},
                       {"samples", excluded.count},
                       {"first_sample", excluded.first}});
  }
  const double render = to_seconds(finished - work.started);
  const double rate = render > 0 ? 1 / render : 0;
  return {{"image_sha256", image_sha256},
          {"width", s.width},
          {"height", s.height},
          {"samples_per_pixel", s.samples_per_pixel},
          {"max_depth", s.max_depth},
          {"seed", s.seed},
          {"precision", name_of(s.precision)},
          {"precision_reason", job.record.precision_reason},
          {"accelerator", name_of(s.accelerator)},
          {"isa", work.isa},
          {"sampler", name_of(s.sampler)},
          {"schedule", name_of(s.schedule)},
          {"row_order", name_of(s.row_order)},
          {"scene_sha256", job.record.scene},
          {"spheres", work.requirements.spheres},
          {"duplicates_removed", job.record.duplicates_removed},
          {"features", work.requirements.features()},
          {"accelerator_bytes", work.accelerator_bytes},
          {"threads", work.contributor_threads},
          {"workers", work.contributors.size()},
          {"samples", counts.samples},
          {"rays", counts.rays},
          {"samples_per_second", static_cast<double>(counts.samples) * rate},
          {"rays_per_second", static_cast<double>(counts.rays) * rate},
          {"nonfinite_samples", counts.nonfinite},
          {"nonfinite_pixels", work.framebuffer.excluded().size()},
          {"nonfinite", std::move(located)},
          {"seconds",
           {{"load", job.record.load_seconds}, {"build", work.build_seconds}, {"render", render}}},
          {"version", PARRAY_VERSION}};
}

}  // namespace parray
