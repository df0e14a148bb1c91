#include "coordinator/job.h"

#include <algorithm>
#include <array>
#include <limits>
#include <utility>

#include "common/base/error.h"
#include "common/image/error_estimate.h"
#include "common/image/passes.h"
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
  if (!record.settings.in_passes()) {
    return;
  }
  if (record.passes.empty()) {
    next_pass(Time{});
  } else {
    work->expected_samples =
        next_pass_size(work->framebuffer.state(work->largest_radiance), record.settings, 0)
            .expected;
  }
}

// NOLINTNEXTLINE(readability-make-member-function-const): the work is a part of the job
void Job::begin_pass(std::uint64_t samples) {
  JobWork& w = *work;
  const auto pass = static_cast<std::uint32_t>(w.passes++);
  w.framebuffer.begin_pass(
      counts_after_pass(w.framebuffer.state(w.largest_radiance), record.settings, pass, samples));
  const WorkRect& rect = w.framebuffer.pass_rect();
  if (rect.units() > 0) {
    const auto all = static_cast<double>(rect.units()) * record.settings.width;
    w.leases.add(rect, static_cast<double>(w.framebuffer.sample_count(rect)) / all);
  }
}

/// What the time left allows, at the speed of the pass before. Of how fast an earlier life was
/// nothing is known: no more than it has done.
std::uint64_t Job::affordable_samples(Time now) const {
  const double limit = record.settings.time_limit;
  if (limit == 0 || work->passes == 0) {
    return std::numeric_limits<std::uint64_t>::max();
  }
  if (work->started == never) {
    return work->framebuffer.counts().samples;
  }
  const double left = limit - record.load_seconds - to_seconds(now - work->started);
  const double took = to_seconds(now - work->pass_began);
  const std::uint64_t traced = work->framebuffer.counts().samples - work->samples_before_pass;
  if (left <= 0 || took <= 0) {
    return 0;
  }
  return static_cast<std::uint64_t>(static_cast<double>(traced) / took * left);
}

bool Job::next_pass(Time now) {
  JobWork& w = *work;
  if (!record.settings.in_passes()) {
    return false;
  }
  const bool recorded = w.passes < record.passes.size();  // an earlier life has decided
  const PassSize next =
      recorded ? PassSize{record.passes[w.passes]}
               : next_pass_size(w.framebuffer.state(w.largest_radiance), record.settings,
                                static_cast<std::uint32_t>(w.passes), affordable_samples(now));
  w.stopped_by = next.stop;
  if (!recorded) {
    w.expected_samples = next.samples > 0 ? next.expected : w.framebuffer.counts().samples;
  }
  if (next.samples == 0) {
    return false;
  }
  w.samples_before_pass = w.framebuffer.counts().samples;
  w.pass_began = w.started == never ? never : now;
  begin_pass(next.samples);
  if (w.leases.done()) {
    return false;  // no pixel may have more
  }
  if (!recorded) {
    record.passes.push_back(next.samples);
  }
  return true;
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
  // A pass begins when all blocks of the one before are in: in the order of their epochs.
  const auto begin_recorded = [&] {
    while (work->leases.done() && work->passes < record.passes.size()) {
      begin_pass(record.passes[work->passes]);
    }
  };
  begin_recorded();
  store.each_block(record.id, [&](const std::string& bytes) {
    const RowBlock block = row_block_from_bytes(bytes);
    work->leases.restore(block.rect);
    work->framebuffer.merge(block);
    begin_recorded();
  });
  work->samples_before_pass = work->framebuffer.counts().samples;  // that this life will measure
  if (work->leases.done() && next_pass(Time{})) {
    store.put_job(record);
  }
}

// NOLINTNEXTLINE(readability-make-member-function-const): likewise
void Job::note_all_merged() {
  for (const WorkRect& rect : work->leases.pending()) {
    work->leases.restore(rect);
  }
}

bool Job::whole() const {
  const std::vector<std::uint32_t>& pixels = work->framebuffer.samples();
  return std::find(pixels.begin(), pixels.end(), 0U) == pixels.end();
}

double Job::progress(Time now) const {
  const RenderSettings& s = record.settings;
  if (!s.in_passes()) {
    return work->leases.progress();
  }
  double share = work->expected_samples == 0
                     ? 0
                     : static_cast<double>(work->framebuffer.counts().samples) /
                           static_cast<double>(work->expected_samples);
  if (s.time_limit > 0 && work->started != never) {
    share = std::max(share, to_seconds(now - work->started) / s.time_limit);
  }
  return std::min(share, 1.0);
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
                  {"sampler", name_of(record.settings.sampler)},
                  {"whole", record.state == JobState::done}};
  if (!job.open()) {
    return summary;
  }
  const JobWork& work = *job.work;
  summary["whole"] = job.whole();
  summary["progress"] = job.progress(now);
  const std::uint64_t samples = work.framebuffer.counts().samples;
  if (work.started != never && now > work.started && samples > 0) {
    const double elapsed = to_seconds(now - work.started);
    const double progress = summary["progress"];
    summary["samples_per_second"] = static_cast<double>(samples) / elapsed;
    summary["seconds_left"] = progress > 0 ? elapsed * (1 - progress) / progress : -1;
  }
  return summary;
}

/// As asked for; the mean where pixels have different numbers.
static json samples_per_pixel_of(const Job& job) {
  const RenderSettings& s = job.record.settings;
  if (!s.in_passes()) {
    return s.samples_per_pixel;
  }
  const std::uint64_t pixels = std::uint64_t{s.width} * s.height;
  const std::uint64_t samples = job.work->framebuffer.counts().samples;
  return samples % pixels == 0 ? json(samples / pixels)
                               : json(static_cast<double>(samples) / static_cast<double>(pixels));
}

static json error_of(const Job& job, const ErrorEstimate& estimate) {
  const TraceCounts& counts = job.work->framebuffer.counts();
  const auto known = [](double value) { return value < 0 ? json() : json(value); };
  const double lost = counts.samples == 0
                          ? 0
                          : static_cast<double>(counts.lost) * TraceCounts::lost_unit /
                                static_cast<double>(counts.samples);
  return {{"rmse", known(estimate.rmse)},
          {"low", known(estimate.low)},
          {"high", known(estimate.high)},
          {"half_width_p50", known(estimate.half_width_p50)},
          {"half_width_p99", known(estimate.half_width_p99)},
          {"method", error_method},
          {"truncation", lost * job.work->largest_radiance}};
}

static json make_report(const Job& job, const std::string& image_sha256, Time finished,
                        const ErrorEstimate& estimate) {
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
          {"samples_per_pixel", samples_per_pixel_of(job)},
          {"error", error_of(job, estimate)},
          {"adaptive", s.adaptive},
          {"passes", job.record.passes},
          {"stopped_by", name_of(work.stopped_by)},
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

FinishedPicture finish_picture(const Job& job, Time finished) {
  const Framebuffer& framebuffer = job.work->framebuffer;
  const double largest = job.work->largest_radiance;
  Image image = resolve_image(framebuffer, largest);
  ErrorEstimate estimate = estimate_error(framebuffer.state(largest));
  json report = make_report(job, image_sha256(image), finished, estimate);
  return {
      std::move(image), {framebuffer.samples(), std::move(estimate.half_width)}, std::move(report)};
}

}  // namespace parray
