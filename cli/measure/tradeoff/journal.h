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

/// What measurements must have in common to be told together.
struct Identity {
  std::string scene_sha256;
  std::uint32_t width = 0;
  std::uint32_t height = 0;
  std::string settings;  ///< options_of() the scene's own, and their seed
  int threads = 0;
  std::string processor;
};

/// The directory of a trade: what has been measured is kept there as it is measured, and another
/// run of the same command goes on with it.
///
/// `runs.csv` has a line for each render, `state.json` everything else but the reference, which is
/// `reference.exr`.
class Journal {
 public:
  /// Makes the directory if need be. `restart`: forgets what is there. Throws InputError when it
  /// holds the trade of something else, or what it holds is damaged.
  Journal(std::filesystem::path directory, const Identity& identity, bool restart);

  [[nodiscard]] std::filesystem::path file(const std::string& name) const {
    return directory_ / name;
  }
  [[nodiscard]] std::filesystem::path reference() const { return file("reference.exr"); }

  /// Facts of the stages before: read and changed by them, kept by keep_state().
  [[nodiscard]] nlohmann::json& state() { return state_; }
  void keep_state() const;

  [[nodiscard]] const std::vector<Run>& runs() const { return runs_; }
  [[nodiscard]] bool has(const std::string& options, std::uint64_t seed) const {
    return known_.contains({options, seed});
  }
  /// Throws RunError when it cannot be written.
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

/// Width and height of the trade in a directory; none if there is none.
std::optional<std::pair<std::uint32_t, std::uint32_t>> size_in(
    const std::filesystem::path& directory);

/// A line of runs.csv, without its end, and the other way round (throws std::runtime_error).
std::string csv_line(const Run& run);
Run run_of_csv(const std::string& line);

}  // namespace parray::tradeoff
