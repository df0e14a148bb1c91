#include "cli/child_process/child_process.h"

#include <csignal>
#include <optional>
#include <thread>

#include "common/process/stop_signal.h"

namespace parray::child_process {
namespace {

/// A running child. The destructor ends its group.
class Child {
 public:
  explicit Child(pid_t pid) : pid_(pid) {}
  ~Child() {
    if (!ended_) end_group();
  }
  Child& operator=(Child&&) = delete;

  /// Returns how the child has ended, or nothing if it still runs after `limit`. `interruptible`:
  /// throws Interrupted after a signal.
  std::optional<ChildEnd> wait(Time limit, bool interruptible) {
    const SteadyClock clock;
    const Time end = clock.now() + limit;
    for (;;) {
      if (auto found = end_of_child(pid_)) {
        ended_ = true;
        return found;
      }
      if (clock.now() >= end) return {};
      if (interruptible) check_interrupted();
      std::this_thread::sleep_for(milliseconds(5));
    }
  }

  /// Ends the child's group. SIGTERM comes first, because mpirun then ends its ranks, which have
  /// their own groups.
  void end_group() {
    kill(-pid_, SIGTERM);
    if (!wait(seconds(5), false)) {
      kill(-pid_, SIGKILL);
      wait(seconds(5), false);
    }
  }

 private:
  pid_t pid_;
  bool ended_ = false;
};

}  // namespace

ChildEnd run_child(const std::vector<std::string>& arguments,
                   const std::vector<std::string>& variables, const std::filesystem::path& log,
                   Time limit) {
  Child child(start_child({.arguments = arguments,
                           .environment = environment_with(variables),
                           .output = log,
                           .messages = log}));
  if (auto end = child.wait(limit, true)) return *end;
  child.end_group();
  ChildEnd late;
  late.timed_out = true;
  return late;
}

}  // namespace parray::child_process
