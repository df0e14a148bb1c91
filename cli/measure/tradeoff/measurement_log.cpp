#include "cli/measure/tradeoff/measurement_log.h"

#include <array>
#include <fstream>
#include <sstream>
#include <stdexcept>
#include <system_error>

#include "cli/output/picture/partial_file.h"
#include "cli/output/text.h"
#include "common/base/error.h"
#include "common/base/files.h"
#include "common/base/json_text.h"
#include "common/base/printable.h"
#include "common/base/text.h"
#include "common/scene/limits.h"

namespace parray::tradeoff {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

constexpr const char* remedy = ": use another directory, or start again with --restart";
constexpr int format_version = 3;

/// The numbers of a run, in the order of the file's columns.
constexpr std::array<std::pair<const char*, double Run::*>, 15> run_columns = {
    {{"seconds", &Run::seconds},
     {"cpu_seconds", &Run::cpu_seconds},
     {"samples_per_pixel", &Run::samples},
     {"rays_per_sample", &Run::rays},
     {"mse", &Run::mse},
     {"mse_scatter", &Run::mse_scatter},
     {"mse_8bit", &Run::mse_8bit},
     {"quantisation", &Run::quantisation},
     {"bias", &Run::bias},
     {"claimed_rmse", &Run::claimed},
     {"claimed_low", &Run::low},
     {"claimed_high", &Run::high},
     {"truncation", &Run::truncation},
     {"passes", &Run::passes},
     {"denoise_seconds", &Run::denoise_seconds}}};
/// The values that exist for each confidence level. Each has a column per level.
constexpr std::array<std::pair<const char*, ByLevel Run::*>, 2> by_level = {
    {{"coverage", &Run::coverage}, {"claim", &Run::claims}}};

std::string header() {
  std::string text = "options,seed";
  for (const auto& [name, member] : run_columns) text += std::string(",") + name;
  for (const auto& [name, member] : by_level) {
    for (const double level : interval_levels) {
      text += std::string(",") + name + formatted("_%.0f", 100 * level);
    }
  }
  return text;
}

std::string shown(const fs::path& path) { return printable(path.string(), 4096); }

json json_of(const Identity& identity) {
  return {{"scene_sha256", identity.scene_sha256},
          {"width", identity.width},
          {"height", identity.height},
          {"settings", identity.settings},
          {"threads", identity.threads},
          {"processor", identity.processor},
          {"format", format_version}};
}

double number(std::string_view text) {
  const std::optional<double> value = parsed<double>(text);
  if (!value) throw std::runtime_error("'" + std::string(text) + "' is not a number");
  return *value;
}

std::string text_of(const fs::path& path) {
  const std::optional<std::string> text = read_file(path);
  if (!text) throw InputError(shown(path) + ": cannot be read: check its permissions");
  return *text;
}

}  // namespace

std::optional<std::pair<std::uint32_t, std::uint32_t>> size_in(const fs::path& directory) {
  if (!fs::exists(directory / state_name)) return std::nullopt;
  const json state = json::parse(text_of(directory / state_name), nullptr, false);
  const auto side = [&](const char* name) -> std::uint32_t {
    const json::json_pointer at(std::string("/identity/") + name);
    if (state.is_discarded() || !state.contains(at) || !state[at].is_number_unsigned()) return 0;
    const auto pixels = state[at].get<std::uint64_t>();
    return pixels <= limits::max_image_side ? static_cast<std::uint32_t>(pixels) : 0;
  };
  const std::pair size(side("width"), side("height"));
  return size.first > 0 && size.second > 0 ? std::optional(size) : std::nullopt;
}

std::string csv_line(const Run& run) {
  std::string line = run.options + "," + std::to_string(run.seed);
  for (const auto& [name, member] : run_columns) line += formatted(",%.9g", run.*member);
  for (const auto& [name, member] : by_level) {
    for (const double share : run.*member) line += formatted(",%.6g", share);
  }
  return line;
}

Run run_of_csv(const std::string& line) {
  const std::vector<std::string_view> cells = split_at(',', line);
  Run run;
  if (cells.size() != 2 + run_columns.size() + by_level.size() * interval_levels.size()) {
    throw std::runtime_error("another number of cells than the header");
  }
  run.options = cells[0];
  const auto seed = parsed<decltype(run.seed)>(cells[1]);
  if (!seed) throw std::runtime_error("'" + std::string(cells[1]) + "' is not a seed");
  run.seed = *seed;
  for (std::size_t i = 0; i < run_columns.size(); ++i) {
    run.*run_columns.at(i).second = number(cells[2 + i]);
  }
  std::size_t cell = 2 + run_columns.size();
  for (const auto& [name, member] : by_level) {
    for (double& share : run.*member) share = number(cells[cell++]);
  }
  return run;
}

MeasurementLog::MeasurementLog(fs::path directory, const Identity& identity, bool restart)
    : directory_(std::move(directory)) {
  std::error_code failed;
  fs::create_directories(directory_, failed);
  if (!fs::is_directory(directory_)) {
    throw InputError(shown(directory_) + ": cannot be made: " + failed.message() +
                     ": use another directory");
  }
  check_output_path(file("tradeoff.json"));
  if (restart) {
    for (const fs::path& old : {file(state_name), file(runs_name), reference()}) {
      fs::remove(old, failed);
      if (failed) {
        throw InputError(shown(old) + ": cannot be deleted: " + failed.message() +
                         ": use another directory");
      }
    }
  }
  if (fs::exists(file(state_name))) {
    read_state(identity);
    if (fs::exists(file(runs_name))) read_runs();
    return;
  }
  if (fs::exists(file(runs_name)) || fs::exists(reference())) {
    throw InputError(shown(directory_) + ": has measurements but no state.json" + remedy);
  }
  state_ = {{"identity", json_of(identity)}};
  keep_state();
}

void MeasurementLog::read_state(const Identity& identity) {
  state_ = json::parse(text_of(file(state_name)), nullptr, false);
  if (!state_.is_object() || !state_.contains("identity") || !state_["identity"].is_object()) {
    throw InputError(shown(file(state_name)) + ": is damaged" + remedy);
  }
  const json wanted = json_of(identity);
  for (const auto& [name, value] : wanted.items()) {
    const json there = state_["identity"].value(name, json());
    if (there != value) {
      throw InputError(shown(directory_) + ": has measurements with other " + name + " (" +
                       printable(there.dump(), 200) + ", now " + value.dump() + ")" + remedy);
    }
  }
}

void MeasurementLog::read_runs() {
  std::string text = text_of(file(runs_name));
  const std::size_t whole = text.rfind('\n') == std::string::npos ? 0 : text.rfind('\n') + 1;
  if (whole < text.size()) {  // the program ended while it wrote the last line
    text.resize(whole);
    fs::resize_file(file(runs_name), whole);
  }
  std::istringstream lines(text);
  std::string line;
  for (std::size_t place = 1; std::getline(lines, line); ++place) {
    try {
      if (place == 1) {
        if (line != header()) throw std::runtime_error("another header");
        continue;
      }
      add(run_of_csv(line));
    } catch (const std::runtime_error& error) {
      throw InputError(shown(file(runs_name)) + ":" + std::to_string(place) + ": " +
                       printable(error.what(), 200) + remedy);
    }
  }
}

void MeasurementLog::keep_state() const {
  write_text_file(file(state_name), json_document(state_));
}

void MeasurementLog::add(Run run) {
  known_.insert({run.options, run.seed});
  runs_.push_back(std::move(run));
}

void MeasurementLog::append(const Run& run) {
  const bool fresh = !fs::exists(file(runs_name)) || fs::file_size(file(runs_name)) == 0;
  std::ofstream output(file(runs_name), std::ios::binary | std::ios::app);
  output << (fresh ? header() + "\n" : "") + csv_line(run) + "\n" << std::flush;
  if (!output) throw RunError("writing " + shown(file(runs_name)) + ": the disk may be full");
  add(run);
}

}  // namespace parray::tradeoff
