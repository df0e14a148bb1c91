#pragma once

#include <filesystem>
#include <nlohmann/json.hpp>
#include <optional>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "cli/measure/tradeoff/analysis.h"

namespace parray::tradeoff {

/// Properties that all measurements in one directory share.
struct Identity {
  std::string scene_sha256;
  std::uint32_t width = 0;
  std::uint32_t height = 0;
  std::string settings;  ///< one text: options_of() of the scene's own settings, and their seed
  int threads = 0;
  std::string processor;
};

inline constexpr const char* runs_name = "runs.csv";
inline constexpr const char* state_name = "state.json";

/// The directory of measurements. Every measurement is written as soon as it is made, so that a
/// later run of the same command continues.
///
/// `runs.csv` has a line for each render, `reference.exr` the reference, `state.json` everything
/// else.
class MeasurementLog {
 public:
  /// Makes the directory if it is missing. `restart` deletes existing measurements. Throws
  /// InputError if the directory cannot be made or written, or if its measurements are damaged or
  /// have another identity.
  MeasurementLog(std::filesystem::path directory, const Identity& identity, bool restart);

  /// Returns the path of a file in the directory.
  [[nodiscard]] std::filesystem::path file(const std::string& name) const {
    return directory_ / name;
  }
  [[nodiscard]] std::filesystem::path reference() const { return file("reference.exr"); }

  /// Returns the contents of state.json: a map with the results of finished stages of the session.
  /// The caller may change them; keep_state() then writes the file. keep_state() throws RunError.
  [[nodiscard]] nlohmann::json& state() { return state_; }
  void keep_state() const;

  /// Returns all renders of runs.csv, in the order of the file.
  [[nodiscard]] const std::vector<Run>& runs() const { return runs_; }
  /// Returns whether runs() contains a render with these options (Run::options) and this seed.
  [[nodiscard]] bool has(const std::string& options, std::uint64_t seed) const {
    return known_.contains({options, seed});
  }
  /// Adds a render to runs() and to the file. Throws RunError if the file cannot be written.
  void append(const Run& run);

 private:
  void read_state(const Identity& identity);
  void read_runs();
  void add(Run run);

  std::filesystem::path directory_;
  nlohmann::json state_;
  std::vector<Run> runs_;
  std::set<std::pair<std::string, std::uint64_t>> known_;
};

/// Returns the width and height of the measurements in a directory, or nothing if there are none
/// or state.json is damaged. Throws InputError if state.json cannot be read.
std::optional<std::pair<std::uint32_t, std::uint32_t>> size_in(
    const std::filesystem::path& directory);

/// Convert a run to a line of runs.csv, without line end, and back. run_of_csv() throws
/// std::runtime_error for a line that csv_line() does not make.
std::string csv_line(const Run& run);
Run run_of_csv(const std::string& line);

}  // namespace parray::tradeoff
