#include "cli/commands/printing.h"

#include <filesystem>
#include <iostream>
#include <string_view>

#include "cli/input/particles/packed_file.h"
#include "cli/output/progress.h"
#include "cli/output/text.h"
#include "common/base/json_text.h"
#include "common/base/printable.h"

namespace parray::commands {

using nlohmann::json;

void print_json(const json& document) { std::cout << json_document(document); }

void warn_of_duplicates(const Duplicates& duplicates, const std::string& scene_file) {
  if (duplicates.count == 0) return;
  std::cerr << "parray: warning: " << printable(scene_file, 500) << ": "
            << counted(duplicates.count, "sphere") << " left out, because an earlier sphere has "
            << "the same centre and radius: the first is sphere " << duplicates.first
            << " (from 0), which equals sphere " << duplicates.first_of << "\n";
}

std::string note_text(const ParticleNote& note) {
  return std::to_string(note.count) + " " + printable(note.text, 500);
}

json notes_json(const std::vector<ParticleNote>& notes) {
  json list = json::array();
  for (const ParticleNote& note : notes) {
    list.push_back({{"key", note.key}, {"count", note.count}, {"text", note.text}});
  }
  return list;
}

std::string name_of(const ParticleFile& file) {
  return file.path.empty() ? "standard input" : printable(file.path.string(), 4096);
}

json notes_json(const std::vector<ParticleFile>& files) {
  json list = json::array();
  for (const ParticleFile& file : files) {
    for (json note : notes_json(file.facts.notes)) {
      note["file"] = name_of(file);
      list.push_back(std::move(note));
    }
  }
  return list;
}

void print_notes(const std::vector<ParticleFile>& files) {
  for (const ParticleFile& file : files) {
    if (file.facts.notes.empty()) continue;
    std::string text;
    for (const ParticleNote& note : file.facts.notes) {
      text += (text.empty() ? "" : "; ") + note_text(note);
    }
    std::cerr << "parray: " << name_of(file) << ": " << text << "\n";
  }
}

std::string progress_cell(const JobStatus& job) {
  return std::to_string(static_cast<int>(100 * job.progress)) + " %";
}

std::string left_cell(const JobStatus& job) {
  return job.ended() || job.seconds_left < 0 ? "" : duration_text(job.seconds_left);
}

std::string queue_cell(const JobStatus& job) {
  if (job.queue_place == 0) return "";
  const std::string place = std::to_string(job.queue_place);
  return job.starts_in < 0 ? place : place + " (" + duration_text(job.starts_in) + ")";
}

std::string error_cell(const JobStatus& job) {
  if (!job.ended()) return target_text(job);
  return job.error.known() ? formatted("%.3g", job.error.rmse) : "";
}

std::string samples_cell(const JobStatus& job) {
  const bool limited = job.samples_per_pixel > 0;
  if (job.samples_taken > 0 && (job.ended() || !limited)) return mean_text(job.samples_taken);
  return limited ? std::to_string(job.samples_per_pixel) : "";
}

static std::string job_samples_text(const JobStatus& job) {
  if (job.state == "done" && job.samples_taken > 0) {
    return mean_text(job.samples_taken) + (job.samples_taken == 1 ? " sample" : " samples") +
           " each";
  }
  std::string limit =
      job.samples_per_pixel > 0 ? counted(job.samples_per_pixel, "sample") + " each" : "";
  if (!limit.empty() && job.samples_taken <= 0) return limit;
  return limit + (limit.empty() ? "" : ", ") + mean_text(job.samples_taken) + " traced";
}

/// Returns what ended a job that is done, for people. Empty: its number of samples.
static std::string end_text(const json& map) {
  const std::string ended_by = map.value("ended_by", std::string());
  return ended_by == "target_error"        ? "the target of the error"
         : ended_by == "target_half_width" ? "the target of the half-width"
         : ended_by == "time_limit"        ? "the time limit"
                                           : "";
}

static void add_times(std::vector<std::pair<std::string, std::string>>& facts, const json& map) {
  const auto number = [&map](const char* key) {
    const json value = map.value(key, json());
    return value.is_number() ? value.get<double>() : -1;
  };
  for (const char* key : {"submitted", "started", "finished"}) {
    if (number(key) > 0) facts.emplace_back(key, moment_text(number(key)));
  }
  if (number("seconds_taken") >= 0) {
    facts.emplace_back("time taken", duration_text(number("seconds_taken")));
  }
}

static void print_frames(const json& list) {
  if (list.empty()) return;
  std::vector<std::vector<std::string>> rows;
  for (const json& frame : list) {
    rows.push_back({frame.at("frame").dump(), frame.at("job").dump(),
                    printable(frame.at("state").get<std::string>()),
                    printable(frame.at("reason").get<std::string>(), 500)});
  }
  std::cout << table_text({"FRAME", "JOB", "STATE", "REASON"}, rows);
}

void print_job(const json& map, bool as_json) {
  if (as_json) return print_json(map);
  const JobStatus job = job_status(map);
  std::vector<std::pair<std::string, std::string>> facts = {
      {"job", std::to_string(job.id)},
      {"name", printable(job.name)},
      {"state", printable(job.state)},
      {"priority", std::to_string(job.priority)},
      {"picture", std::to_string(job.width) + " x " + std::to_string(job.height) + " pixels, " +
                      job_samples_text(job) + " (" + printable(job.sampler) + ")"},
      {"progress", progress_cell(job)}};
  if (job.error.known()) {
    facts.emplace_back(job.ended() ? "error" : "error so far", figures_text(job.error));
  }
  if (!target_text(job).empty()) facts.emplace_back("target", target_text(job));
  if (!end_text(map).empty()) facts.emplace_back("ended by", end_text(map));
  add_times(facts, map);
  if (job.frames > 0) facts.emplace_back("frames", frames_text(job) + " done");
  if (map.contains("frame")) {
    facts.emplace_back("frame", map.at("frame").dump() + " of series " + map.at("series").dump());
  }
  if (!job.user.empty()) facts.insert(facts.begin() + 2, {"user", printable(job.user)});
  if (!job.ended() && job.samples_per_second > 0) {
    facts.emplace_back("speed", with_unit(job.samples_per_second, "samples/s"));
    facts.emplace_back("time left", left_cell(job));
  }
  if (!job.waits_for.empty()) facts.emplace_back("waits for", printable(job.waits_for, 500));
  if (job.queue_place > 0) {
    facts.emplace_back(
        "queue",
        "place " + std::to_string(job.queue_place) +
            (job.starts_in < 0 ? "" : ", begins in about " + duration_text(job.starts_in)));
  }
  if (!job.warning.empty()) facts.emplace_back("warning", printable(job.warning, 500));
  if (!job.flag.empty()) facts.emplace_back("flag", printable(job.flag, 500));
  if (!job.reason.empty()) facts.emplace_back("reason", printable(job.reason, 500));
  std::cout << list_text(facts);
  print_frames(map.value("frame_list", json::array()));
  for (const json& event : map.value("events", json::array())) {
    std::cout << "  " << moment_text(event.at("at").get<double>()) << "  "
              << printable(event.at("what").get<std::string>(), 500) << "\n";
  }
}

/// Quotes a word for a POSIX shell if necessary.
static std::string quoted(const std::string& word) {
  constexpr std::string_view plain =
      "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789_-./=,+:@%";
  if (!word.empty() && word.find_first_not_of(plain) == std::string::npos) return word;
  std::string text = "'";
  for (const char c : word) text += c == '\'' ? std::string("'\\''") : std::string(1, c);
  return text + "'";
}

std::string shell_line(const std::vector<std::string>& words) {
  std::string line;
  for (const std::string& word : words) line += (line.empty() ? "" : " ") + quoted(word);
  return line;
}

std::string default_picture(const std::string& scene) {
  if (scene == standard_input_argument) return "picture.exr";
  return std::filesystem::path(scene).stem().string() + ".exr";
}

}  // namespace parray::commands
