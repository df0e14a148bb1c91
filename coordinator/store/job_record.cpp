#include "coordinator/store/job_record.h"

#include <array>
#include <nlohmann/json.hpp>
#include <utility>

#include "common/base/error.h"
#include "common/base/printable.h"
#include "common/scene/limits.h"
#include "proto/keys.h"
#include "proto/settings_json.h"

namespace parray::store {

using nlohmann::json;

static constexpr std::array<std::string_view, 6> state_names = {"queued", "running", "paused",
                                                                "done",   "failed",  "cancelled"};

std::string_view name_of(JobState state) { return state_names[static_cast<std::size_t>(state)]; }

bool is_unfinished(JobState state) {
  return state == JobState::queued || state == JobState::running || state == JobState::paused;
}

void JobRecord::note(double at, std::string what) {
  constexpr std::size_t most = 64;
  constexpr std::ptrdiff_t kept_of_old = 16;
  if (events.size() == most) {
    events.erase(events.begin() + kept_of_old);
  }
  events.push_back({at, std::move(what)});
}

json events_to_json(const std::vector<JobEvent>& events) {
  json list = json::array();
  for (const JobEvent& event : events) {
    list.push_back({{"at", event.at}, {"what", event.what}});
  }
  return list;
}

std::string record_to_json(const JobRecord& job) {
  const json map = {{"token", job.token},
                    {"name", job.name},
                    {"user", job.user},
                    {"priority", job.priority},
                    {"settings", settings_to_json(job.settings)},
                    {"tile", job.tile},
                    {"precision_reason", job.precision_reason},
                    {"duplicates_removed", job.duplicates_removed},
                    {"load_seconds", job.load_seconds},
                    {"reserved_seconds", job.reserved_seconds},
                    {"scene", job.scene},
                    {"passes", job.passes},
                    {"state", static_cast<int>(job.state)},
                    {"reason", job.reason},
                    {"report", job.report},
                    {"scene_bytes", job.scene_bytes},
                    {"flag", job.flag},
                    {"convictions", job.convictions},
                    {"share", job.share},
                    {"max_failures", job.max_failures},
                    {"series", job.series},
                    {"series_id", job.series_id},
                    {"frame", job.frame},
                    {"frames", job.frames},
                    {"ended", job.ended},
                    {"events", events_to_json(job.events)}};
  return map.dump(-1, ' ', false, json::error_handler_t::replace);
}

static JobState state_from(const json& value) {
  if (!value.is_number_unsigned() || value.get<std::size_t>() >= state_names.size()) {
    throw RunError("there is no state " + value.dump());
  }
  return static_cast<JobState>(value.get<std::size_t>());
}

/// Of a picture of these settings; a pass that adds nothing would leave it without an end.
static std::vector<std::uint64_t> passes_from(const json& map, const RenderSettings& settings) {
  auto passes = naturals_in(map, "passes");
  const std::uint64_t most =
      std::uint64_t{settings.width} * settings.height * limits::max_samples_per_pixel;
  for (const std::uint64_t samples : passes) {
    if (samples == 0 || samples > most) {
      throw RunError("there is no pass of " + std::to_string(samples) + " samples");
    }
  }
  return passes;
}

/// Of a key that earlier versions did not write.
static std::uint64_t later_number(const json& map, const char* key,
                                  std::uint64_t most = UINT64_MAX) {
  return map.contains(key) ? natural_in(map, key, most) : 0;
}

static double share_from(const json& map) {
  const double share = map.value("share", 1.0);
  if (!(share >= least_share && share <= largest_share)) {
    throw RunError("there is no share of " + std::to_string(share));
  }
  return share;
}

JobRecord record_from_json(JobId id, std::string_view text) {
  try {
    const json map = json::parse(text);
    JobRecord job;
    job.id = id;
    job.token = map.at("token");
    job.name = map.at("name");
    job.user = map.value("user", std::string());
    job.priority = static_cast<std::uint32_t>(natural_in(map, "priority", UINT32_MAX));
    job.settings = settings_from_json(map.at("settings"));
    job.tile = static_cast<std::uint32_t>(later_number(map, "tile", limits::max_image_side));
    job.precision_reason = map.at("precision_reason");
    job.duplicates_removed = later_number(map, "duplicates_removed");
    job.load_seconds = map.at("load_seconds");
    job.reserved_seconds = map.value("reserved_seconds", 0.0);
    job.scene = map.at("scene");
    job.passes = passes_from(map, job.settings);
    job.state = state_from(map.at("state"));
    job.reason = map.at("reason");
    job.report = map.at("report");
    job.scene_bytes = later_number(map, "scene_bytes");
    job.flag = map.value("flag", std::string());
    job.convictions = later_number(map, "convictions");
    job.share = share_from(map);
    job.max_failures = static_cast<std::uint32_t>(later_number(map, "max_failures", UINT32_MAX));
    job.series = map.value("series", std::string());
    job.series_id = later_number(map, "series_id");
    job.frame = static_cast<std::uint32_t>(later_number(map, "frame", limits::max_frame));
    job.frames = static_cast<std::uint32_t>(later_number(map, "frames", limits::max_frames));
    job.ended = map.value("ended", 0.0);
    for (const json& event : map.value("events", json::array())) {
      job.events.push_back({event.at("at"), event.at("what")});
    }
    return job;
  } catch (const std::exception& error) {
    throw RunError("the state's record of job " + std::to_string(id) +
                   " is damaged: " + printable(error.what(), 400));
  }
}

}  // namespace parray::store
