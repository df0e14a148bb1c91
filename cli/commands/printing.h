#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <utility>
#include <vector>

#include "cli/farm/client.h"
#include "cli/input/scene_file/duplicates.h"
#include "cli/input/scene_file/scene_file.h"

/// What the commands print, on stdout but for warnings.
namespace parray::commands {

/// A JSON document, indented; bytes that are not UTF-8 become U+FFFD.
void print_json(const nlohmann::json& document);

/// A job's facts, a line each, or its map as JSON.
void print_job(const nlohmann::json& map, bool as_json);

/// One line on stderr about spheres that were left out of a scene, if any were.
void warn_of_duplicates(const Duplicates& duplicates, const std::string& scene_file);

/// A line on stderr for each file of which something was guessed, dropped or left out.
void print_notes(const std::vector<ParticleFile>& files);

/// A note as people read it: "3 elements guessed from names".
std::string note_text(const ParticleNote& note);

/// [{"key", "count", "text"}, ...]; of several files each also with "file".
nlohmann::json notes_json(const std::vector<ParticleNote>& notes);
nlohmann::json notes_json(const std::vector<ParticleFile>& files);

/// For messages: a file's path, or "standard input".
std::string name_of(const ParticleFile& file);

/// A job's progress and time left: "43 %", "12 s"; empty where there is nothing to say.
std::string progress_cell(const JobStatus& job);
std::string left_cell(const JobStatus& job);
/// A done job's RMSE; of one with a target how far it is: "error 0.021 of 0.01".
std::string error_cell(const JobStatus& job);

}  // namespace parray::commands
