#include "cli/check/doctor/machine.h"

#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdlib>
#include <fstream>
#include <string>
#include <system_error>

#include "cli/output/processor.h"
#include "cli/output/text.h"
#include "common/base/cgroup_limits.h"
#include "common/base/cpu_count.h"
#include "common/base/printable.h"
#include "common/math/float_mode.h"
#include "common/scene/requirements.h"
#include "common/scene/settings.h"
#include "common/schedule/work_plan.h"
#include "common/trace/isa.h"
#include "proto/window.h"

namespace parray::doctor {
namespace {

namespace fs = std::filesystem;

/// Returns the differences from the default mode of IEEE 754. Empty: none.
std::string oddities(unsigned control) {
  std::string text;
  const auto add = [&](unsigned bits, const char* name) {
    const bool odd = ((control ^ float_control::ieee) & bits) != 0;
    if (odd) text += (text.empty() ? "" : ", ") + std::string(name);
  };
  add(float_control::denormal_results, "denormal results become 0");
  add(float_control::denormal_operands, "denormal operands count as 0");
  add(float_control::rounding, "rounding is not to nearest");
  add(float_control::exceptions, "exceptions stop the program");
  return text;
}

/// Returns a value of /proc/meminfo in bytes. 0: unknown.
std::uint64_t memory_bytes(const std::string& key) {
  std::ifstream file("/proc/meminfo");
  constexpr std::uint64_t kibibyte = 1024;
  return kibibyte * std::strtoull(value_of(file, key).c_str(), nullptr, 10);
}

/// Returns the directory of std::filesystem::temp_directory_path(), without its check: the error of
/// that check does not name the directory.
fs::path temporary_place() {
  for (const char* variable : {"TMPDIR", "TMP", "TEMP", "TEMPDIR"}) {
    const char* const place = std::getenv(variable);  // NOLINT(concurrency-mt-unsafe)
    if (place != nullptr) return place;
  }
  return "/tmp";
}

/// Returns why a file cannot be made and written in `directory`. Empty: it can.
std::string why_not_writable(const fs::path& directory) {
  std::string name = (directory / ".parray-doctor-XXXXXX").string();
  const int file = mkstemp(name.data());
  if (file < 0) return std::generic_category().message(errno);
  const bool written = write(file, "1", 1) == 1 && fsync(file) == 0;
  const int error = errno;
  close(file);
  unlink(name.c_str());
  return written ? "" : std::generic_category().message(error);
}

}  // namespace

CheckResult check_processor() {
  const std::string model = processor_model();
  const auto cpus = static_cast<std::uint64_t>(usable_cpus());
  nlohmann::json names = nlohmann::json::array();
  std::string list;
  for (const Isa isa : instruction_sets()) {
    names.push_back(name_of(isa));
    list += (list.empty() ? "" : ", ") + std::string(name_of(isa));
  }
  CheckResult found = passed(model + ", " + counted(cpus, "CPU") + " available; kernels: " + list +
                             "; auto uses " + std::string(name_of(best_isa())));
  found.facts = {{"model", model},
                 {"cpus", cpus},
                 {"instruction_sets", names},
                 {"automatic", name_of(best_isa())}};
  return found;
}

CheckResult check_float_mode(std::span<const unsigned> found) {
  std::string odd;
  std::size_t threads = 0;
  for (const unsigned control : found) {
    const std::string here = oddities(control);
    if (!here.empty()) {
      odd = here;
      ++threads;
    }
  }
  if (threads == 0) {
    return passed("round to nearest, denormals kept, in " + counted(found.size(), "thread"));
  }
  return warned(odd + ", in " + std::to_string(threads) + " of " + counted(found.size(), "thread") +
                    " when they start",
                "tracing is not affected, because it sets its own mode; look for a library that "
                "was linked with -ffast-math (LD_PRELOAD?)");
}

CheckResult check_float_mode() {
  const int threads = usable_cpus();
  std::vector<unsigned> found(static_cast<std::size_t>(threads) + 1, float_control::ieee);
  found[0] = float_control::read();
#pragma omp parallel for num_threads(threads) schedule(static, 1)
  for (int i = 0; i < threads; ++i) found[static_cast<std::size_t>(i) + 1] = float_control::read();
  return check_float_mode(found);
}

CheckResult check_memory(std::uint64_t available, std::uint64_t total) {
  if (total == 0) return skipped("the system does not report its memory", "");
  if (available == 0) return skipped("the system does not report its available memory", "");
  const std::string text = bytes_text(available) + " available of " + bytes_text(total);
  constexpr std::uint64_t enough = std::uint64_t{256} << 20;  // a few million spheres
  CheckResult found = available >= enough
                          ? passed(text)
                          : warned(text, "end other programs before rendering large scenes");
  found.facts = {{"total_bytes", total}, {"available_bytes", available}};
  return found;
}

CheckResult check_memory() {
  const std::uint64_t total = std::min(memory_bytes("MemTotal"), usable_memory());
  return check_memory(std::min(memory_bytes("MemAvailable"), total), total);
}

CheckResult check_temporary_directory(std::optional<OwnedPath>& scratch) {
  const std::string remedy = "set TMPDIR to a writable directory with free space";
  const fs::path parent = temporary_place();
  const fs::path path = make_directory(parent / "parray-doctor-");
  if (path.empty()) {
    return failed(parent.string() + ": " + std::generic_category().message(errno), remedy);
  }
  scratch.emplace(path);
  const std::string place = printable(path.parent_path().string(), 200);
  const std::string problem = why_not_writable(path);
  if (!problem.empty()) return failed(place + ": " + problem, remedy);
  std::error_code ignored;
  const auto space = fs::space(path, ignored);
  return passed(place + ", " + bytes_text(ignored ? 0 : space.available) + " free");
}

CheckResult check_current_directory(const fs::path& directory) {
  const std::string problem = why_not_writable(directory);
  return problem.empty() ? passed("writable")
                         : warned(problem, "write pictures to another directory with -o");
}

std::uint64_t window_bytes() {
  const RenderSettings settings = resolve_settings(requirements_of({}), {}).settings;
  const WorkPlan plan(settings, {{{0, settings.samples_per_pixel}}, {}});
  const auto ranks = static_cast<std::uint32_t>(usable_cpus());
  constexpr std::uint64_t own_of_rank = 4 << 20;  // Open MPI's buffers (btl_vader_segment_size)
  return WindowLayout(*plan.grid(), ranks).bytes() + ranks * own_of_rank;
}

CheckResult check_shared_memory(std::uint64_t available, std::uint64_t needed) {
  const std::string text = bytes_text(available) + " free in /dev/shm; a picture of 1200 x 800 " +
                           "under MPI needs " + bytes_text(needed);
  CheckResult found =
      available >= needed
          ? passed(text)
          : warned(text,
                   "enlarge /dev/shm (mount -o remount,size=1g /dev/shm; for a container "
                   "--shm-size=1g), or use parray-mpi --mode messages");
  found.facts = {{"available_bytes", available}, {"needed_bytes", needed}};
  return found;
}

CheckResult check_shared_memory() {
  std::error_code problem;
  const auto space = fs::space("/dev/shm", problem);
  if (problem) {
    return skipped("no /dev/shm: " + problem.message(), "use parray-mpi --mode messages");
  }
  return check_shared_memory(space.available, window_bytes());
}

}  // namespace parray::doctor
