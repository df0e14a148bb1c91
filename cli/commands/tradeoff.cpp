#include <array>
#include <cstdlib>
#include <filesystem>
#include <iostream>
#include <memory>
#include <string_view>
#include <tuple>

#include "cli/commands/commands.h"
#include "cli/commands/loading.h"
#include "cli/commands/options.h"
#include "cli/commands/prepare.h"
#include "cli/commands/printing.h"
#include "cli/measure/tradeoff/session.h"
#include "cli/output/picture/partial_file.h"
#include "cli/output/processor.h"
#include "cli/output/progress.h"
#include "common/base/cpu_count.h"
#include "common/base/error.h"
#include "common/base/json_text.h"
#include "common/base/printable.h"
#include "common/base/text.h"
#include "common/process/stop_signal.h"
#include "common/scene/limits.h"
#include "common/scene/requirements.h"
#include "common/scene/scene_bytes.h"
#include "common/scene/settings.h"

namespace parray::commands {
namespace {

constexpr NumberRange budget_range{1, 1e6};

struct TradeoffCommand {
  std::string scene;
  std::string directory;
  double error = 0;  ///< 0: not given
  double seconds = 120;
  std::uint32_t width = 0;  ///< 0: not given
  std::uint32_t height = 0;
  std::vector<std::string> also;
  RenderOptions none;  ///< no options: the command measures the scene's own settings
  std::optional<std::uint32_t> threads;
  bool restart = false;
  bool quiet = false;
  bool as_json = false;
};

/// Shows the progress as `parray render` shows that of a job.
class Meter {
 public:
  Meter(const TradeoffCommand& command)
      : began_(clock_.now()),
        progress_(progress_style(command.quiet), std::cerr, terminal_columns) {
    status_.name = "tradeoff";
    status_.state = "running";
  }

  void show(double done) {
    status_.progress = done;
    const double took = to_seconds(clock_.now() - began_);
    status_.seconds_left = done > 0.02 ? took / done * (1 - done) : -1;
    progress_.show(clock_.now(), status_);
  }
  void end() {
    status_.progress = 1;
    status_.state = "done";
    progress_.show(clock_.now(), status_);
  }

 private:
  SteadyClock clock_;
  Time began_;
  JobStatus status_;
  Progress progress_;
};

/// Returns the scene's settings, replaced by `options` of `parray render`, with the size of `base`.
RenderSettings also_settings(const std::string& options, const SceneFile& file,
                             const RenderSettings& base) {
  CommandLine line;
  RenderOptions render;
  render.add_to(line);
  bool denoise = false;
  line.flag("--denoise", denoise, "Denoise the picture");
  RenderSettings settings;
  try {
    line.parse(options);
    for (const GivenOption& given : line.given_options()) {
      constexpr std::array<std::string_view, 6> of_all{
          "--width", "--height", "--seed", "--schedule", "--row-order", "--transparent"};
      if (given.group != particles_group && !place_in(of_all, given.name)) continue;
      throw InputError("all variants trace the same picture in the same way: leave out " +
                       given.name);
    }
    settings =
        resolve_settings(requirements_of(file.scene, usable_cpus()), render.over(file.settings))
            .settings;
  } catch (const UsageError& error) {
    throw InputError("--also '" + printable(options, 200) + "': " + printable(error.what(), 300));
  } catch (const InputError& error) {
    throw InputError("--also '" + printable(options, 200) + "': " + error.what());
  }
  if (settings.time_limit > 0 || settings.target_half_width > 0 || !settings.passes.empty()) {
    throw InputError("--also '" + printable(options, 200) +
                     "': the only limits that can be measured are --spp and --target-error");
  }
  if (denoise && settings.samples_per_pixel < 2) {
    throw InputError("--also '" + printable(options, 200) +
                     "': --denoise needs at least two samples per pixel: use --spp 2 or more");
  }
  if (denoise && settings.target_error > 0) {
    throw InputError("--also '" + printable(options, 200) +
                     "': --target-error and --denoise cannot be measured together: use --spp");
  }
  check_isa(settings.isa);
  settings.replicates = denoise;
  settings.width = base.width;
  settings.height = base.height;
  return settings;
}

tradeoff::Request request_of(const TradeoffCommand& command, const SceneFile& file) {
  tradeoff::Request request;
  request.scene =
      resolve_settings(requirements_of(file.scene, usable_cpus()), file.settings).settings;
  request.base = tradeoff::with_size(request.scene, command.width, command.height, command.seconds);
  const auto before = tradeoff::size_in(command.directory);
  if (before && command.width == 0 && command.height == 0 && !command.restart) {
    std::tie(request.base->width, request.base->height) = *before;
  }
  check_settings(request.base);
  for (const std::string& options : command.also) {
    request.also.push_back(also_settings(options, file, request.base));
  }
  if (command.error > 0) request.error = command.error;
  request.seconds = command.seconds;
  return request;
}

/// Returns the command to copy. Empty: there is no answer.
std::string answer_command(const TradeoffCommand& command,
                           const tradeoff::TradeoffResults& results) {
  std::string options = results.answer_facts.value("options", "");
  if (options.empty()) return options;
  return shell_line({"parray", "render", command.scene, "-o", default_picture(command.scene)}) +
         " " + options;
}

constexpr std::array<const char*, 4> tables{"tradeoff.csv", "farms.csv", "intervals.csv",
                                            "tradeoff.json"};

/// Throws InputError if a table would overwrite a file from which the scene was read, or if the
/// measurements would, which --restart deletes.
void check_files(const TradeoffCommand& command, const SceneFile& scene) {
  InputFiles inputs = inputs_of(scene);
  inputs.add(command.scene);
  const std::filesystem::path directory(command.directory);
  for (const char* const table : tables) inputs.check(directory / table);
  inputs.check(directory / tradeoff::runs_name);
  inputs.check(directory / tradeoff::state_name);
}

void write_tables(const tradeoff::TradeoffResults& results, const tradeoff::MeasurementLog& log,
                  const nlohmann::json& document) {
  write_text_file(log.file(tables[0]), csv_of(results));
  write_text_file(log.file(tables[1]), farms_csv_of(results));
  write_text_file(log.file(tables[2]), intervals_csv_of(results));
  write_text_file(log.file(tables[3]), json_document(document));
}

int run(const TradeoffCommand& command) {
  const SceneFile file = load_scene(command.scene, command.none);
  check_files(command, file);
  const tradeoff::Request request = request_of(command, file);
  const auto threads = static_cast<int>(command.threads.value_or(usable_cpus()));
  const DeferredInterrupts deferred;
  tradeoff::MeasurementLog log(
      command.directory,
      {scene_identity(file.scene), request.base->width, request.base->height,
       tradeoff::options_of(request.base) + " --seed " + std::to_string(request.base->seed),
       threads, processor_model()},
      command.restart);
  const StopPoller watch(interrupt_noted);
  tradeoff::Bench bench(file.scene, threads, watch.stop());
  tradeoff::TradeoffResults results;
  try {
    Meter meter(command);
    results =
        tradeoff::measure_tradeoff(request, bench, log, [&](double done) { meter.show(done); });
    meter.end();
  } catch (const Interrupted&) {
    throw Interrupted("interrupted: the same command continues with the measurements in " +
                      printable(command.directory, 4096));
  }
  results.scene_file = command.scene;
  const std::string answer = answer_command(command, results);
  if (!answer.empty()) results.answer_facts["command_line"] = answer;
  const nlohmann::json document = json_of(results);
  write_tables(results, log, document);
  write_plot_scripts(results, command.directory);
  const char* const path = std::getenv("PATH");  // NOLINT(concurrency-mt-unsafe): no thread sets it
  const auto no_plots = tradeoff::draw_plots(command.directory, path == nullptr ? "" : path);
  if (no_plots) std::cerr << "parray: " + *no_plots + "\n";
  if (command.as_json) {
    print_json(document);
  } else {
    std::cout << (answer.empty() ? "" : "  " + answer + "\n\n") << results.answer << "\n\n"
              << text_of(results) << "\n"
              << printable(command.directory, 4096)
              << " has tradeoff.csv, farms.csv, intervals.csv, tradeoff.json, the reference and "
              << (no_plots ? "scripts for plots.\n" : "plots.\n");
  }
  return 0;
}

}  // namespace

void add_tradeoff(CommandLine& line) {
  Command command = line.command(
      "tradeoff", "Measure the cost of accuracy on this machine; find the fastest settings");
  const auto options = std::make_shared<TradeoffCommand>();
  add_scene(command, options->scene);
  command
      .option("-o,--output", options->directory,
              "Directory for tables, plots (PDF, SVG, PNG) and measurements. The same command "
              "continues with the measurements")
      .type_name("DIR")
      .completes(Completes::directories)
      .group(output_group)
      .required()
      .forbid_empty();
  add_real_number(
      command, "--error", ranges::target_error, options->error,
      "Required RMSE of the picture, in linear radiance (default: that of the scene's own "
      "settings)");
  add_real_number(command, "--time-budget", budget_range, options->seconds,
                  "Approximate seconds for all measurements (default: 120)");
  add_whole_number(
      command, "--width", 1, limits::max_image_side, options->width,
      "Pixels across during the measurement (default: the scene's shape, with at most 200 pixels "
      "on the shorter side; the error hardly depends on the number of pixels)");
  add_whole_number(command, "--height", 1, limits::max_image_side, options->height, "Pixels down");
  add_threads(command, options->threads);
  command
      .option("--also", options->also,
              "Additional settings to measure: options of parray render in quotes, also --denoise. "
              "Can be given several times")
      .type_name("'OPTIONS'")
      .one_value_each();
  command.flag("--restart", options->restart, "Delete the measurements of an earlier run in DIR");
  add_quiet(command, options->quiet);
  add_json(command, options->as_json);
  command.example(
      "parray tradeoff scenes/glass.json -o trade --error 0.01",
      "finds the fastest settings for this error (RMSE, linear radiance), in two minutes");
  command.runs([options] { return run(*options); });
}

}  // namespace parray::commands
