#include "cli/check/doctor/mpi_trial.h"

#include <unistd.h>

#include <fstream>
#include <system_error>
#include <vector>

#include "cli/check/doctor/tracing.h"
#include "cli/child_process/child_process.h"
#include "cli/output/picture/partial_file.h"
#include "cli/output/text.h"
#include "common/base/printable.h"

namespace parray::doctor {
namespace {

namespace fs = std::filesystem;

/// Returns the lines of `log` without lines of dashes and empty lines, which frame Open MPI's
/// messages.
std::string words_of(const fs::path& log) {
  std::ifstream file(log);
  std::string text;
  for (std::string line; std::getline(file, line) && text.size() < 300;) {
    if (line.find_first_not_of("- \t") != std::string::npos) {
      text += (text.empty() ? "" : " ") + line;
    }
  }
  return text.empty() ? "it printed nothing" : printable(text, 300);
}

std::vector<std::string> variables_for_root() {
  // mpirun refuses to run as root without these. Two ranks on loopback are harmless.
  if (geteuid() != 0) return {};
  return {"OMPI_ALLOW_RUN_AS_ROOT=1", "OMPI_ALLOW_RUN_AS_ROOT_CONFIRM=1"};
}

CheckResult judge_report(const fs::path& file, const std::string& expected) {
  std::ifstream text(file);
  const nlohmann::json report = nlohmann::json::parse(text);
  const std::string found = report.at("image_sha256");
  const std::string transport = report.at("mpi").at("transport");
  const std::size_t ranks = report.at("mpi").at("ranks").size();
  if (found != expected) {
    return failed("two ranks make a different picture than this process: SHA-256 " +
                      found.substr(0, 16) + " instead of " + expected.substr(0, 16),
                  "install parray and parray-mpi from the same build");
  }
  if (ranks != 2) {
    return failed("mpirun -n 2 started " + counted(ranks, "rank") + " instead of 2",
                  "use the mpirun of the MPI that ParRay was built with (Debian: openmpi-bin)");
  }
  if (transport != "window") {
    return warned("the same picture from 2 ranks, but by " + transport +
                      ": windows (one-sided communication) do not work",
                  "check the variable OMPI_MCA_osc and the free space in /dev/shm");
  }
  return passed("the same picture from 2 ranks, over a window: SHA-256 " + expected.substr(0, 16));
}

}  // namespace

fs::path program_directory() {
  std::error_code problem;
  const fs::path self = fs::read_symlink("/proc/self/exe", problem);
  return problem ? fs::path() : self.parent_path();
}

CheckResult check_mpi_trial(const MpiTrial& trial) {
  if (!trial.mpirun) {
    return skipped("no mpirun in PATH", "to use parray-mpi, install openmpi-bin (Debian)");
  }
  if (!executable(trial.parray_mpi)) {
    return skipped("no parray-mpi in " + printable(trial.parray_mpi.parent_path().string(), 200),
                   "install or build parray-mpi beside parray");
  }
  const fs::path& directory = trial.directory;
  write_text_file(directory / "scene.json", std::string(doctor_scene_text));
  const ChildEnd end =
      run_child({trial.mpirun->string(), "-n", "2", "--oversubscribe", trial.parray_mpi.string(),
                 (directory / "scene.json").string(), "-o", (directory / "mpi.exr").string(),
                 "--report", (directory / "mpi.json").string(), "--quiet", "--threads", "1"},
                variables_for_root(), directory / "mpi.log", trial.limit);
  const char* const remedy = "check whether mpirun -n 2 hostname works; see man parray-mpi";
  if (end.timed_out) {
    return failed("mpirun -n 2 parray-mpi did not end within " +
                      duration_text(to_seconds(trial.limit)) + ": " +
                      words_of(directory / "mpi.log"),
                  remedy);
  }
  if (end.status != 0) {
    return failed("mpirun -n 2 parray-mpi ended with status " + std::to_string(end.status) + ": " +
                      words_of(directory / "mpi.log"),
                  remedy);
  }
  return judge_report(directory / "mpi.json", trial.image_sha256);
}

}  // namespace parray::doctor
