#include <iostream>
#include <memory>

#include "cli/check/doctor/check.h"
#include "cli/commands/commands.h"
#include "cli/commands/options.h"
#include "cli/commands/printing.h"
#include "cli/output/text.h"
#include "common/process/stop_signal.h"
#include "proto/clock.h"

namespace parray::commands {
namespace {

using nlohmann::json;

constexpr std::size_t status_width = 9;
constexpr std::size_t name_width = 21;

std::string padded(std::string text, std::size_t width) {
  text.resize(std::max(text.size() + 1, width), ' ');
  return text;
}

void print_result(const CheckResult& result) {
  std::cout << padded(std::string(name_of(result.status)), status_width)
            << padded(result.name, name_width) << result.detail << "\n";
  if (!result.remedy.empty()) {
    std::cout << std::string(status_width + name_width, ' ') << "-> " << result.remedy << "\n";
  }
  std::cout << std::flush;
}

/// Returns the worst status of all checks that were not skipped.
CheckStatus status_of(const std::vector<CheckResult>& results) {
  return count_of(results, CheckStatus::failed) > 0    ? CheckStatus::failed
         : count_of(results, CheckStatus::warning) > 0 ? CheckStatus::warning
                                                       : CheckStatus::ok;
}

void print_summary(const std::vector<CheckResult>& results, double seconds) {
  const std::size_t failures = count_of(results, CheckStatus::failed);
  std::cout << "\n"
            << (failures == 0 ? "This machine is fit for ParRay"
                              : "This machine is not fit for ParRay")
            << ": " << counted(results.size(), "check") << ", " << failures << " failed, "
            << counted(count_of(results, CheckStatus::warning), "warning") << ", "
            << count_of(results, CheckStatus::skipped) << " skipped, " << duration_text(seconds)
            << "\n";
}

json to_json(const std::vector<CheckResult>& results, double seconds) {
  json list = json::array();
  for (const CheckResult& result : results) {
    list.push_back({{"name", result.name},
                    {"status", name_of(result.status)},
                    {"detail", result.detail},
                    {"remedy", result.remedy},
                    {"facts", result.facts}});
  }
  return {{"version", PARRAY_VERSION},
          {"status", name_of(status_of(results))},
          {"failed", count_of(results, CheckStatus::failed)},
          {"warnings", count_of(results, CheckStatus::warning)},
          {"skipped", count_of(results, CheckStatus::skipped)},
          {"seconds", seconds},
          {"checks", std::move(list)}};
}

int doctor(bool as_json, bool extremes) {
  const SteadyClock clock;
  const Time begin = clock.now();
  const DeferredInterrupts deferred;  // checks remove their temporary directory
  std::vector<CheckResult> results;
  for (const Check& check : doctor_checks(extremes)) {
    check_interrupted();
    results.push_back(run(check));
    if (!as_json) print_result(results.back());
  }
  const double seconds = to_seconds(clock.now() - begin);
  as_json ? print_json(to_json(results, seconds)) : print_summary(results, seconds);
  return status_of(results) == CheckStatus::failed ? 1 : 0;
}

}  // namespace

void add_doctor(CommandLine& line) {
  Command command = line.command(
      "doctor", "Check whether this machine is fit: arithmetic, libraries, ZeroMQ, MPI");
  const auto as_json = std::make_shared<bool>(false);
  const auto extremes = std::make_shared<bool>(false);
  command.flag(
      "--extremes", *extremes,
      "Also check numerical extremes: rounding, furnace scenes, scaled scenes, hits on spheres "
      "of all sizes");
  add_json(command, *as_json);
  command.example("parray doctor", "prints a line for each check, with a remedy if it fails");
  command.example("parray doctor --extremes", "for a new kind of processor, compiler or emulator");
  command.runs([as_json, extremes] { return doctor(*as_json, *extremes); });
}

}  // namespace parray::commands
