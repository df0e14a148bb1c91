#include "cli/check/doctor/check.h"

#include <algorithm>
#include <array>
#include <cstdlib>
#include <filesystem>
#include <memory>
#include <optional>
#include <system_error>
#include <utility>

#include "cli/check/doctor/extremes.h"
#include "cli/check/doctor/machine.h"
#include "cli/check/doctor/messages.h"
#include "cli/check/doctor/tracing.h"
#include "common/base/cpu_count.h"
#include "common/process/child.h"
#include "common/process/stop_signal.h"
#include "common/trace/isa.h"

namespace parray::doctor {
namespace {

namespace fs = std::filesystem;

constexpr Time loopback_patience = seconds(3);  ///< for messages over loopback

void add_tracing(std::vector<Check>& checks) {
  for (const Isa isa : instruction_sets()) {
    const std::string name(name_of(isa));
    const TracerMaker make = tracers_of(isa);
    checks.push_back({name + " picture", [make] { return check_picture(make); }});
  }
  const int threads = usable_cpus();
  const TracerMaker best = tracers_of(Isa::automatic);
  checks.push_back({"threads", [best, threads] { return check_threads(best, threads); }});
  constexpr int times = 60;
  checks.push_back({"repetition", [threads] {
                      return check_repetition([] { return trace_fingerprint(); }, times, threads);
                    }});
}

void add_extremes(std::vector<Check>& checks) {
  checks.push_back({"rounding", [] { return check_rounding(); }});
  for (const Isa isa : instruction_sets()) {
    const std::string name(name_of(isa));
    const TracerMaker make = tracers_of(isa);
    checks.push_back({name + " furnaces", [make] { return check_furnaces(make); }});
    checks.push_back({name + " self-hits", [make] { return check_self_hits(make); }});
    checks.push_back({name + " scaling", [make] { return check_scaling(make); }});
  }
  constexpr std::uint64_t rays = 100'000;
  checks.push_back({"sphere hits", [] { return check_hit_errors(worst_hit_errors(rays)); }});
}

CheckResult check_mpi_here(const fs::path& directory) {
  const char* const path = std::getenv("PATH");  // NOLINT(concurrency-mt-unsafe): no thread sets it
  MpiTrial trial;
  trial.mpirun = find_program("mpirun", path == nullptr ? "" : path);
  std::error_code ignored;  // without a path, parray-mpi is missing
  trial.parray_mpi = fs::read_symlink("/proc/self/exe", ignored).parent_path() / "parray-mpi";
  trial.directory = directory;
  trial.image_sha256 = doctor_image_sha256(tracers_of(Isa::automatic), 1);
  return check_mpi_trial(trial);
}

/// Returns a check that needs the temporary directory, and is skipped without it.
Check on_disk(const std::string& name, const std::shared_ptr<std::optional<OwnedPath>>& scratch,
              CheckResult (*check)(const fs::path& directory)) {
  return {name, [scratch, check] {
            return *scratch ? check((*scratch)->path())
                            : skipped("needs the temporary directory", "");
          }};
}

}  // namespace

std::string_view name_of(CheckStatus status) {
  constexpr std::array<std::string_view, 4> names{"ok", "warning", "failed", "skipped"};
  return names.at(static_cast<std::size_t>(status));
}

CheckResult passed(std::string detail) { return {"", CheckStatus::ok, std::move(detail), ""}; }
CheckResult warned(std::string detail, std::string remedy) {
  return {"", CheckStatus::warning, std::move(detail), std::move(remedy)};
}
CheckResult failed(std::string detail, std::string remedy) {
  return {"", CheckStatus::failed, std::move(detail), std::move(remedy)};
}
CheckResult skipped(std::string detail, std::string remedy) {
  return {"", CheckStatus::skipped, std::move(detail), std::move(remedy)};
}

CheckResult run(const Check& check) {
  CheckResult found;
  try {
    found = check.run();
  } catch (const Interrupted&) {
    throw;
  } catch (const std::exception& error) {
    found = failed(error.what(), "fix the problem in the message, then run parray doctor again");
  }
  found.name = check.name;
  return found;
}

std::size_t count_of(const std::vector<CheckResult>& results, CheckStatus status) {
  return static_cast<std::size_t>(std::ranges::count(results, status, &CheckResult::status));
}

std::vector<Check> doctor_checks(bool extremes) {
  const auto scratch = std::make_shared<std::optional<OwnedPath>>();
  std::vector<Check> checks = {
      {"processor", check_processor},
      {"memory", [] { return check_memory(); }},
      {"temporary directory", [scratch] { return check_temporary_directory(*scratch); }},
      {"current directory", [] { return check_current_directory("."); }},
      {"shared memory", [] { return check_shared_memory(); }},
      {"libraries", check_libraries},
      {"float mode", [] { return check_float_mode(); }}};
  add_tracing(checks);
  if (extremes) add_extremes(checks);
  checks.push_back(on_disk("pictures", scratch, check_pictures));
  checks.push_back(on_disk("state", scratch, check_state));
  checks.push_back({"messages", [] { return check_messages(loopback_patience); }});
  checks.push_back(on_disk("keys", scratch, [](const fs::path& directory) {
    return check_keys(loopback_patience, directory);
  }));
  checks.push_back(on_disk("mpi", scratch, check_mpi_here));
  return checks;
}

}  // namespace parray::doctor
