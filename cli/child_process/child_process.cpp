#include "cli/child_process/child_process.h"

#include <csignal>
#include <optional>
#include <thread>

#include "common/process/stop_signal.h"

namespace parray::child_process {
namespace {

/// Returns how the child has ended, or nothing if it still runs after `limit`. Calls `poll` now and
/// then.
std::optional<ChildEnd> wait_for(pid_t child, Time limit, const auto& poll) {
  const SteadyClock clock;
  const Time end = clock.now() + limit;
  for (;;) {
    if (auto found = end_of_child(child)) return found;
    if (clock.now() >= end) return {};
    poll();
    std::this_thread::sleep_for(milliseconds(5));
  }
}

/// Ends the child's group. SIGTERM comes first, because mpirun then ends its ranks, which have
/// their own groups.
void end_group(pid_t child) {
  for (const int signal : {SIGTERM, SIGKILL}) {
    kill(-child, signal);
    if (wait_for(child, seconds(5), [] {})) return;
  }
}

}  // namespace

ChildEnd run_child(const std::vector<std::string>& arguments,
                   const std::vector<std::string>& variables, const std::filesystem::path& log,
                   Time limit) {
  const pid_t child = start_child({.arguments = arguments,
                                   .environment = environment_with(variables),
                                   .output = log,
                                   .messages = log});
  try {
    if (auto end = wait_for(child, limit, check_interrupted)) return *end;
  } catch (const Interrupted&) {
    end_group(child);
    throw;
  }
  end_group(child);
  ChildEnd late;
  late.timed_out = true;
  return late;
}

}  // namespace parray::child_process
