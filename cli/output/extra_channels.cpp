#include "cli/output/extra_channels.h"

#include <algorithm>
#include <iterator>
#include <utility>

#include "cli/output/denoising.h"
#include "cli/output/recipe.h"
#include "common/process/stop_signal.h"
#include "common/trace/integrator/extra_channels.h"
#include "common/trace/tracer.h"
#include "proto/clock.h"

namespace parray {

ExtraChannels extra_channels(const Aovs& aovs, const RenderSettings& settings,
                             std::shared_ptr<const Scene> scene, int threads,
                             const Aovs& for_finishing) {
  const bool denoise = settings.replicates;
  if (!denoise && for_finishing.empty() && std::all_of(aovs.begin(), aovs.end(), is_statistic)) {
    scene = nullptr;
  }
  return {.aovs = aovs,
          .settings = settings,
          .scene = std::move(scene),
          .threads = threads,
          .for_finishing = for_finishing,
          .denoise = denoise};
}

bool wants_statistics(const Aovs& aovs) {
  return std::any_of(aovs.begin(), aovs.end(), is_statistic);
}

std::unique_ptr<PathTracer> tracer_of(const ExtraChannels& extra, const std::string& scene_id) {
  auto accelerator = extra.accelerators->find(scene_id, extra.settings);
  if (!accelerator) {
    accelerator = extra.accelerators->build(scene_id, *extra.scene, extra.settings, extra.threads);
  }
  return make_path_tracer(std::move(accelerator), extra.scene->camera, extra.settings);
}

namespace {

void add_statistics(Picture& picture, const Aovs& aovs) {
  if (aovs.contains(Aov::samples)) {
    picture.channels.push_back({samples_channel, picture.statistics.samples});
  }
  if (!aovs.contains(Aov::half_width)) return;
  const std::vector<float>& all = picture.statistics.half_width;
  for (const std::size_t c : {0U, 1U, 2U}) {
    std::vector<float> values(all.size() / 3);
    for (std::size_t i = 0; i < values.size(); ++i) {
      values[i] = all[3 * i + c];
    }
    picture.channels.push_back({std::string("half_width.") + "RGB"[c], std::move(values)});
  }
}

}  // namespace

void add_sample_counts(Picture& picture) {
  const auto is_samples = [](const Channel& channel) { return channel.name == samples_channel; };
  if (samples_differ(picture.report) && !picture.statistics.samples.empty() &&
      std::none_of(picture.channels.begin(), picture.channels.end(), is_samples)) {
    picture.channels.push_back({samples_channel, picture.statistics.samples});
  }
}

void add_channels(Picture& picture, const ExtraChannels& extra) {
  std::unique_ptr<PathTracer> tracer;
  if (extra.scene) tracer = tracer_of(extra, picture.report.at("scene_sha256"));
  if (extra.denoise) denoise_picture(picture, *tracer, extra);
  if (extra.aovs.empty() && extra.for_finishing.empty()) return;
  const SteadyClock clock;
  const Time begin = clock.now();
  const auto trace = [&](const Aovs& wanted, Channels& into) {
    if (!tracer || std::all_of(wanted.begin(), wanted.end(), is_statistic)) return;
    Channels traced = trace_channels(*tracer, *extra.scene, extra.settings, wanted, extra.threads,
                                     check_interrupted);
    std::move(traced.begin(), traced.end(), std::back_inserter(into));
  };
  trace(extra.aovs, picture.channels);
  Aovs others;
  std::set_difference(extra.for_finishing.begin(), extra.for_finishing.end(), extra.aovs.begin(),
                      extra.aovs.end(), std::inserter(others, others.end()));
  trace(others, picture.traced);
  add_statistics(picture, extra.aovs);
  for (const Aov aov : extra.aovs) {
    picture.report["aovs"].push_back(name_of(aov));
  }
  picture.report.at("seconds")["aovs"] = to_seconds(clock.now() - begin);
}

}  // namespace parray
