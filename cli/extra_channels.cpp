#include "cli/extra_channels.h"

#include "cli/interrupt.h"
#include "common/scene/scene_bytes.h"
#include "common/trace/features.h"
#include "proto/clock.h"

namespace parray {

ExtraChannels extra_channels(const Aovs& aovs, const RenderSettings& settings,
                             const std::string& scene_bytes, int threads) {
  if (aovs.empty()) return {};
  return {aovs, settings, scene_bytes, threads};
}

void add_channels(Picture& picture, const ExtraChannels& extra) {
  if (extra.aovs.empty()) return;
  const SteadyClock clock;
  const Time begin = clock.now();
  picture.channels = trace_features(scene_from_bytes(extra.scene_bytes), extra.settings, extra.aovs,
                                    extra.threads, check_interrupted);
  nlohmann::json& names = picture.report["aovs"] = nlohmann::json::array();
  for (const Aov aov : extra.aovs) {
    names.push_back(name_of(aov));
  }
  picture.report.at("seconds")["aovs"] = to_seconds(clock.now() - begin);
}

}  // namespace parray
