#include "coordinator/jobs/report.h"

#include <algorithm>
#include <limits>
#include <nlohmann/json.hpp>

#include "common/adaptive/passes.h"
#include "common/adaptive/replicates.h"
#include "common/scene/settings.h"
#include "proto/messages.h"
#include "proto/settings_json.h"

namespace parray::coordinator {

using nlohmann::json;

/// Number of pixels with non-finite samples that a report lists: enough to find the cause.
static constexpr std::size_t most_located = 20;

/// Returns the requested number, or the mean if pixels have different numbers.
static json samples_per_pixel_of(const JobPicture& job) {
  const RenderSettings& s = job.settings();
  if (!s.in_passes()) return s.samples_per_pixel;
  const std::uint64_t pixels = std::uint64_t{s.width} * s.height;
  const std::uint64_t samples = job.framebuffer().counts().samples;
  return samples % pixels == 0 ? json(samples / pixels)
                               : json(static_cast<double>(samples) / static_cast<double>(pixels));
}

static json error_of(const JobPicture& job, const ErrorFigures& figures) {
  const TraceCounts& counts = job.framebuffer().counts();
  const double lost = counts.samples == 0
                          ? 0
                          : static_cast<double>(counts.lost) * TraceCounts::lost_unit /
                                static_cast<double>(counts.samples);
  json error = error_to_json(figures);
  error["method"] = error_method;
  error["truncation"] = lost * job.scene().largest_radiance;
  return error;
}

static json make_report(const JobPicture& job, const JobRecord& record, const RenderFacts& facts,
                        const std::string& image_sha256, const ErrorEstimate& estimate,
                        const Fill& fill) {
  const Framebuffer& framebuffer = job.framebuffer();
  const TraceCounts& counts = framebuffer.counts();
  json located = json::array();
  for (const auto& [pixel, excluded] : framebuffer.excluded()) {
    if (located.size() == most_located) break;
    located.push_back({{"x", pixel.second},
                       {"y", pixel.first},
                       {"samples", excluded.count},
                       {"first_sample", excluded.first}});
  }
  const auto [least, most] =
      std::minmax_element(framebuffer.samples().begin(), framebuffer.samples().end());
  // The report states the build time separately.
  const double tracing = std::max(facts.render_seconds - facts.build_seconds, 0.0);
  const auto all = static_cast<double>(counts.samples);
  const double samples = all - std::min(static_cast<double>(facts.samples_before), all);
  const double samples_per_second = tracing > 0 ? samples / tracing : 0;
  const double rays_per_sample = all > 0 ? static_cast<double>(counts.rays) / all : 0;
  json report = settings_in_report(job.settings());
  report.update({{"image_sha256", image_sha256},
                 {"samples_per_pixel", samples_per_pixel_of(job)},
                 {"least_samples", *least},
                 {"most_samples", *most},
                 {"filled_pixels", fill.pixels},
                 {"fill_block", fill.block},
                 {"error", error_of(job, estimate)},
                 {"passes", job.passes().begun()},
                 {"stopped_by", name_of(job.passes().stopped_by())},
                 {"precision_reason", record.precision_reason},
                 {"isa", facts.isa},
                 {"scene_sha256", record.scene},
                 {"spheres", job.scene().requirements.spheres},
                 {"duplicates_removed", record.duplicates_removed},
                 {"features", job.scene().requirements.features()},
                 {"accelerator_bytes", facts.accelerator_bytes},
                 {"threads", facts.threads},
                 {"workers", facts.workers},
                 {"samples", counts.samples},
                 {"rays", counts.rays},
                 {"samples_per_second", samples_per_second},
                 {"rays_per_second", samples_per_second * rays_per_sample},
                 {"nonfinite_samples", counts.nonfinite},
                 {"nonfinite_pixels", framebuffer.excluded().size()},
                 {"nonfinite", std::move(located)},
                 {"seconds",
                  {{"load", record.load_seconds},
                   {"build", facts.build_seconds},
                   {"render", facts.render_seconds},
                   {"deciding", facts.deciding_seconds}}},
                 {"checked_share", job.checked_share()},
                 {"flag", record.flag},
                 {"trace_version", trace_version},
                 {"version", PARRAY_VERSION}});
  if (const std::size_t capsules = job.scene().requirements.capsules; capsules > 0) {
    report["capsules"] = capsules;
  }
  return report;
}

PictureDetail kept_detail(const WorkSettings& settings) {
  return settings.replicates ? PictureDetail::replicates : PictureDetail::statistics;
}

PassTimes ending_times(const RenderSettings& settings, std::uint64_t samples, double elapsed) {
  constexpr double resolving = 70e-9;  // seconds per pixel: mean, part of the hash, memory
  constexpr double stating = 130e-9;   // for the error of a pixel
  constexpr double deciding = 70e-9;   // for the samples of a pixel in an adaptive pass
  const auto pixels = static_cast<double>(std::uint64_t{settings.width} * settings.height);
  const bool placed = settings.adaptive && static_cast<double>(samples) >= pilot_samples * pixels;
  return {elapsed + resolving * pixels, 0, placed ? deciding * pixels : 0, stating * pixels};
}

ShownImage shown_image(const JobPicture& picture) {
  const Framebuffer& framebuffer = picture.framebuffer();
  ShownImage shown{resolve_image(framebuffer, picture.scene().largest_radiance), {}};
  if (!framebuffer.whole()) shown.fill = fill_untraced(shown.image, framebuffer.samples());
  return shown;
}

PictureParts parts_so_far(const JobPicture& picture, bool statistics) {
  PictureParts parts;
  parts.image = shown_image(picture).image;
  if (statistics) {
    const auto samples = picture.framebuffer().samples();
    ErrorEstimate error = estimate_error(picture.view());
    error.half_width.resize(parts.image.rgb.size(), std::numeric_limits<float>::infinity());
    parts.statistics = {{samples.begin(), samples.end()}, std::move(error.half_width)};
  }
  return parts;
}

FinishedPicture finish_picture(const JobPicture& picture, const JobRecord& record,
                               const RenderFacts& facts) {
  auto [image, fill] = shown_image(picture);
  const auto samples = picture.framebuffer().samples();
  ErrorEstimate estimate = picture.error();
  const json report = make_report(picture, record, facts, image_sha256(image), estimate, fill);
  estimate.half_width.resize(image.rgb.size(), std::numeric_limits<float>::infinity());
  PictureStatistics statistics{{samples.begin(), samples.end()}, std::move(estimate.half_width)};
  if (picture.settings().replicates) statistics.replicates = replicates_of(picture.view());
  return {{std::move(image), std::move(statistics)}, report.dump()};
}

ErrorFigures error_in(const std::string& report) {
  const json map = json::parse(report, nullptr, false);
  return error_from_json(map.is_object() ? map.value("error", json()) : json());
}

}  // namespace parray::coordinator
