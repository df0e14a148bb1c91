#include "coordinator/store/job_record.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>
#include <utility>

#include "common/base/error.h"
#include "common/base/json_text.h"
#include "common/base/printable.h"
#include "common/base/sha256.h"
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
  if (events.size() == most) events.erase(events.begin() + kept_of_old);
  events.push_back({at, std::move(what)});
}

void JobCourse::add(const ErrorPoint& point) {
  while (!curve.empty() && curve.back().samples >= point.samples) curve.pop_back();
  if (curve.size() >= most_points) {
    std::size_t kept = 0;
    for (std::size_t i = 1; i < curve.size(); i += 2) curve[kept++] = curve[i];
    curve.resize(kept);
  }
  curve.push_back(point);
}

void JobCourse::forget_picture() {
  progress = 0;
  samples = 0;
  curve.clear();
  error = {};
}

json curve_to_json(const std::vector<ErrorPoint>& curve) {
  json list = json::array();
  for (const ErrorPoint& point : curve) {
    list.push_back({{"seconds", point.seconds},
                    {"samples", point.samples},
                    {"rmse", point.rmse < 0 ? json() : json(point.rmse)}});
  }
  return list;
}

json error_to_json(const adaptive::ErrorFigures& error) {
  const auto known = [](double value) { return value < 0 ? json() : json(value); };
  return {{"rmse", known(error.rmse)},
          {"low", known(error.low)},
          {"high", known(error.high)},
          {"half_width_p50", known(error.half_width_p50)},
          {"half_width_p99", known(error.half_width_p99)}};
}

adaptive::ErrorFigures error_from_json(const json& map) {
  const auto figure = [&map](const char* name) {
    const json value = map.is_object() ? map.value(name, json()) : json();
    const double number = value.is_number() ? value.get<double>() : -1;
    return number >= 0 ? number : -1;
  };
  return {figure("rmse"), figure("low"), figure("high"), figure("half_width_p50"),
          figure("half_width_p99")};
}

NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE(JobEvent, at, what)

json events_to_json(const std::vector<JobEvent>& events) { return events; }

namespace {

double read_positive(const json& map, const char* key) {
  const double value = map.value(key, 0.0);
  if (!(value >= 0 && std::isfinite(value))) {
    throw RunError(std::string("course: ") + key + " is out of range");
  }
  return value;
}

json to_json(const Boxed<RenderSettings>& value) { return settings_to_json(value); }
json to_json(JobState value) { return static_cast<int>(value); }
json to_json(const JobCourse& course) {
  return {{"submitted", course.submitted},        {"started", course.started},
          {"finished", course.finished},          {"taken", course.taken},
          {"progress", course.progress},          {"samples", course.samples},
          {"curve", curve_to_json(course.curve)}, {"error", error_to_json(course.error)}};
}
json to_json(const auto& value) { return value; }

void read(const json& from, Boxed<RenderSettings>& value) { value = settings_from_json(from); }
void read(const json& from, JobState& value) {
  if (!from.is_number_unsigned() || from.get<std::size_t>() >= state_names.size()) {
    throw RunError("the state " + from.dump() + " does not exist");
  }
  value = static_cast<JobState>(from.get<std::size_t>());
}
/// Reads the output of to_json(). Missing members are unknown.
void read(const json& map, JobCourse& course) {
  course.submitted = read_positive(map, "submitted");
  course.started = read_positive(map, "started");
  course.finished = read_positive(map, "finished");
  course.taken = read_positive(map, "taken");
  course.progress = std::min(read_positive(map, "progress"), 1.0);
  course.samples = map.value("samples", std::uint64_t{0});
  for (const json& point : map.value("curve", json::array())) {
    const json rmse = point.value("rmse", json());
    course.add({read_positive(point, "seconds"), read_positive(point, "samples"),
                rmse.is_null() ? -1 : read_positive(point, "rmse")});
  }
  course.error = error_from_json(map.value("error", json()));
}
void read(const json& from, auto& value) { from.get_to(value); }

/// Writes the members of a record, or reads them. Reading throws if a value is missing, has the
/// wrong type or is out of range.
struct RecordFields {
  json map;
  bool reads = false;

  void value(const char* key, auto& value) {
    if (reads) {
      read(map.at(key), value);
    } else {
      map[key] = to_json(value);
    }
  }
  void value(const char* key, std::vector<std::uint64_t>& value) {
    if (reads) {
      value = naturals_in(map, key);
    } else {
      map[key] = value;
    }
  }
  template <typename T>
  void number(const char* key, T& value, T lowest = 0, T highest = std::numeric_limits<T>::max()) {
    if (!reads) {
      map[key] = value;
      return;
    }
    value = static_cast<T>(natural_in(map, key, highest));
    if (value < lowest) throw RunError(std::string(key) + " is out of range");
  }
  /// Leaves out a value that is still the default.
  template <typename T>
  void optional(const char* key, T& value) {
    if (reads ? map.contains(key) : value != T{}) this->value(key, value);
  }

  // The other functions that head_fields() calls.
  void text(const char* key, std::string& value, std::size_t /*longest*/,
            std::size_t /*shortest*/ = 0) {
    this->value(key, value);
  }
  void duration(const char* key, double& value) { this->value(key, value); }
  void settings(const char* key, Boxed<RenderSettings>& value) { this->value(key, value); }
  void number_if_there(const char* key, std::uint64_t& value) {
    if (reads ? map.contains(key) : value != 0) number(key, value);
  }
  void flag_if_there(const char* key, bool& value) { optional(key, value); }
  void text_if_there(const char* key, std::string& value, std::size_t /*longest*/) {
    optional(key, value);
  }
};

/// Visits all fields of a record except its id.
void fields(RecordFields& f, JobRecord& job) {
  head_fields(f, job);
  f.value("token", job.token);
  f.value("scene", job.scene);
  f.value("passes", job.passes);
  f.value("state", job.state);
  f.value("reason", job.reason);
  f.value("report", job.report);
  f.value("user", job.user);
  f.number("tile", job.tile, 0U, limits::max_image_side);
  f.number("scene_bytes", job.scene_bytes);
  f.value("flag", job.flag);
  f.number("convictions", job.fault_findings);
  f.number("series_id", job.series_id);
  f.value("share", job.share);
  f.value("ended", job.ended);
  f.value("events", job.events);
  f.optional("warning", job.warning);
  f.optional("course", job.course);
}

/// Checks values that depend on each other. A pass without samples would never complete a picture.
void check(const JobRecord& job) {
  if (!is_sha256_hex(job.scene)) throw RunError("the digest of its scene is not a SHA-256");
  const std::uint64_t most = pixel_count(job.settings) * limits::max_samples_per_pixel;
  for (const std::uint64_t samples : job.passes) {
    if (samples == 0 || samples > most) {
      throw RunError("a pass has " + std::to_string(samples) + " samples, but must have 1 to " +
                     std::to_string(most));
    }
  }
  if (!(job.share >= least_share && job.share <= largest_share)) {
    throw RunError("the user's share is " + std::to_string(job.share) + ", but must be from " +
                   std::to_string(least_share) + " to " + std::to_string(largest_share));
  }
}

}  // namespace

std::string record_to_json(const JobRecord& job) {
  JobRecord copy = job;  // fields() takes a mutable record
  RecordFields writer;
  fields(writer, copy);
  return json_text(writer.map);
}

JobRecord record_from_json(JobId id, std::string_view text) {
  try {
    RecordFields reader{json::parse(text), true};
    JobRecord job;
    job.id = id;
    fields(reader, job);
    check(job);
    return job;
  } catch (const std::exception& error) {
    throw RunError("the state's record of job " + std::to_string(id) +
                   " is damaged: " + printable(error.what(), 400));
  }
}

}  // namespace parray::store
