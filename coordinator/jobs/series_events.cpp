#include <spdlog/fmt/fmt.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

#include "coordinator/jobs/series.h"

namespace parray::coordinator {
namespace {

/// Equal events of several frames, which one action of a client has caused.
struct SameEvents {
  double at = 0;
  std::size_t frames = 0;
  std::uint32_t frame = 0;  ///< the first
};

/// Keeps the earliest of the events of all frames.
void keep_earliest(std::vector<JobEvent>& kept, const JobEvent& event) {
  if (kept.empty()) {
    kept.push_back(event);
  } else if (event.at < kept.front().at) {
    kept.front() = event;
  }
}

}  // namespace

std::vector<JobEvent> events_of(const Series& series) {
  constexpr double at_once = 5;  // seconds within which one action reaches all frames
  std::vector<JobEvent> submitted;
  std::vector<JobEvent> begun;
  std::map<std::pair<std::string_view, long>, SameEvents> others;
  for (const Job* job : series) {
    for (const JobEvent& event : job->record.events) {
      if (event.what == "done") continue;
      if (event.what.starts_with("submitted")) {
        keep_earliest(submitted, event);
      } else if (event.what == "started") {
        keep_earliest(begun, event);
      } else {
        const auto [entry, is_new] =
            others.try_emplace({event.what, std::lround(event.at / at_once)},
                               SameEvents{event.at, 0, job->record.frame});
        ++entry->second.frames;
        entry->second.at = std::min(entry->second.at, event.at);
      }
    }
  }
  std::vector<JobEvent> all = std::move(submitted);
  all.insert(all.end(), begun.begin(), begun.end());
  for (const auto& [key, same] : others) {
    const bool single = same.frames == 1 && series.size() > 1;
    all.push_back({same.at, single ? fmt::format("frame {}: {}", same.frame, key.first)
                                   : std::string(key.first)});
  }
  std::ranges::stable_sort(all, {}, &JobEvent::at);
  JobRecord shortened;  // keeps the first and the latest
  for (JobEvent& event : all) shortened.note(event.at, std::move(event.what));
  return shortened.events;
}

}  // namespace parray::coordinator
