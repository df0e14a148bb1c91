#include <iostream>
#include <memory>

#include "cli/check/doctor/doctor_checks.h"
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

void print_finding(const Finding& finding) {
  std::cout << padded(std::string(name_of(finding.status)), status_width)
            << padded(finding.name, name_width) << finding.detail << "\n";
  if (!finding.remedy.empty()) {
    std::cout << std::string(status_width + name_width, ' ') << "-> " << finding.remedy << "\n";
  }
  std::cout << std::flush;
}

/// The worst that was found, skipped checks aside.
CheckStatus status_of(const std::vector<Finding>& findings) {
  return count_of(findings, CheckStatus::failed) > 0    ? CheckStatus::failed
         : count_of(findings, CheckStatus::warning) > 0 ? CheckStatus::warning
                                                        : CheckStatus::ok;
}

void print_summary(const std::vector<Finding>& findings, double seconds) {
  const std::size_t failures = count_of(findings, CheckStatus::failed);
  std::cout << "\n"
            << (failures == 0 ? "This machine is fit for ParRay"
                              : "This machine is not fit for ParRay")
            << ": " << counted(findings.size(), "check") << ", " << failures << " failed, "
            << counted(count_of(findings, CheckStatus::warning), "warning") << ", "
            << count_of(findings, CheckStatus::skipped) << " skipped, " << duration_text(seconds)
            << "\n";
}

json to_json(const std::vector<Finding>& findings, double seconds) {
  json list = json::array();
  for (const Finding& finding : findings) {
    list.push_back({{"name", finding.name},
                    {"status", name_of(finding.status)},
                    {"detail", finding.detail},
                    {"remedy", finding.remedy},
                    {"facts", finding.facts}});
  }
  return {{"version", PARRAY_VERSION},
          {"status", name_of(status_of(findings))},
          {"failed", count_of(findings, CheckStatus::failed)},
          {"warnings", count_of(findings, CheckStatus::warning)},
          {"skipped", count_of(findings, CheckStatus::skipped)},
          {"seconds", seconds},
          {"checks", std::move(list)}};
}

int doctor(bool as_json) {
  const SteadyClock clock;
  const Time begin = clock.now();
  const DeferredInterrupts deferred;  // there is a temporary directory to remove
  std::vector<Finding> findings;
  for (const Check& check : doctor_checks()) {
    check_interrupted();
    findings.push_back(run(check));
    if (!as_json) print_finding(findings.back());
  }
  const double seconds = to_seconds(clock.now() - begin);
  if (as_json) {
    print_json(to_json(findings, seconds));
  } else {
    print_summary(findings, seconds);
  }
  return status_of(findings) == CheckStatus::failed ? 1 : 0;
}

}  // namespace

void add_doctor(CommandLine& line, Action& chosen) {
  Command command = line.command(
      "doctor", "Check whether this machine is fit: arithmetic, libraries, ZeroMQ, MPI");
  const auto as_json = std::make_shared<bool>(false);
  add_json(command, *as_json);
  command.example("parray doctor", "a line for each check, with a remedy where one is needed");
  command.on_chosen([as_json, &chosen] { chosen = [as_json] { return doctor(*as_json); }; });
}

}  // namespace parray::commands
