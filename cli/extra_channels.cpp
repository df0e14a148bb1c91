#include "cli/extra_channels.h"

#include <algorithm>
#include <utility>

#include "cli/interrupt.h"
#include "common/scene/scene_bytes.h"
#include "common/trace/features.h"
#include "proto/clock.h"

namespace parray {

ExtraChannels extra_channels(const Aovs& aovs, const RenderSettings& settings,
                             const std::string& scene_bytes, int threads) {
  if (std::all_of(aovs.begin(), aovs.end(), is_statistic)) return {aovs, settings, {}, threads};
  return {aovs, settings, scene_bytes, threads};
}

bool wants_statistics(const Aovs& aovs) {
  return std::any_of(aovs.begin(), aovs.end(), is_statistic);
}

namespace {

void add_statistics(Picture& picture, const Aovs& aovs) {
  if (aovs.contains(Aov::samples)) {
    picture.channels.push_back({"samples", picture.statistics.samples});
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

void add_channels(Picture& picture, const ExtraChannels& extra) {
  if (extra.aovs.empty()) return;
  const SteadyClock clock;
  const Time begin = clock.now();
  if (!extra.scene_bytes.empty()) {
    picture.channels = trace_features(scene_from_bytes(extra.scene_bytes), extra.settings,
                                      extra.aovs, extra.threads, check_interrupted);
  }
  add_statistics(picture, extra.aovs);
  nlohmann::json& names = picture.report["aovs"] = nlohmann::json::array();
  for (const Aov aov : extra.aovs) {
    names.push_back(name_of(aov));
  }
  picture.report.at("seconds")["aovs"] = to_seconds(clock.now() - begin);
}

}  // namespace parray
