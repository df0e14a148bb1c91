#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "cli/farm/client.h"
#include "cli/input/scene_file/duplicates.h"
#include "cli/input/scene_file/scene_file.h"

/// Output of the commands: on stdout, warnings on stderr. The functions *_cell() return texts for
/// the cells of a table.
namespace parray::commands {

/// Prints an indented JSON document. Bytes that are not UTF-8 become U+FFFD.
void print_json(const nlohmann::json& document);

/// Prints the job map of PROTOCOL.md: as JSON, or as one fact per line, followed by its frames and
/// events.
void print_job(const nlohmann::json& map, bool as_json);

/// Prints one line on stderr if duplicate spheres were removed from a scene.
void warn_of_duplicates(const Duplicates& duplicates, const std::string& scene_file);

/// Prints a line on stderr for each file that has notes: the reader guessed missing data, or left
/// something out.
void print_notes(const std::vector<ParticleFile>& files);

/// Returns a note as text: "3 elements guessed from names".
std::string note_text(const ParticleNote& note);

/// Return [{"key", "count", "text"}, ...]. Notes of files also have "file".
nlohmann::json notes_json(const std::vector<ParticleNote>& notes);
nlohmann::json notes_json(const std::vector<ParticleFile>& files);

/// Returns the path of a file for messages, or "standard input".
std::string name_of(const ParticleFile& file);

/// Returns the progress of a job, rounded down: "43 %".
std::string progress_cell(const JobStatus& job);
/// Returns the remaining time of a job, "12 s". Returns "" if it is unknown or the job has ended.
std::string left_cell(const JobStatus& job);
/// Returns the place in the queue, with the time until the job begins if it is known: "3 (12 s)".
/// Returns "" if the job is not in the queue.
std::string queue_cell(const JobStatus& job);
/// Returns the RMSE of a job that has ended, "0.0098", or "" if it is unknown. For another job,
/// returns target_text(): "error 0.021 of 0.01", or "" without a target and while the error is
/// unknown.
std::string error_cell(const JobStatus& job);

/// Returns the mean number of samples per pixel of a job that has ended or has no limit. For other
/// jobs, returns the limit. Without both, returns "".
std::string samples_cell(const JobStatus& job);

/// Joins words into a line that a POSIX shell splits into the same words.
std::string shell_line(const std::vector<std::string>& words);

/// Returns the file name of a scene with the extension .exr, without its folder. Returns
/// "picture.exr" for the standard input.
std::string default_picture(const std::string& scene);

}  // namespace parray::commands
