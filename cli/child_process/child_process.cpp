#include "cli/child_process/child_process.h"

#include <fcntl.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <csignal>
#include <sstream>
#include <string_view>
#include <system_error>
#include <thread>

#include "common/base/error.h"
#include "common/process/stop_signal.h"

namespace parray::child_process {
namespace {

/// As posix_spawn wants it; `texts` must stay where they are.
std::vector<char*> pointers_to(std::vector<std::string>& texts) {
  std::vector<char*> pointers;
  pointers.reserve(texts.size() + 1);
  for (std::string& text : texts) {
    pointers.push_back(text.data());
  }
  pointers.push_back(nullptr);
  return pointers;
}

std::string_view name_in(std::string_view variable) {
  return variable.substr(0, variable.find('='));
}

std::vector<std::string> environment_with(const std::vector<std::string>& variables) {
  std::vector<std::string> result = variables;
  for (char** entry = environ; *entry != nullptr; ++entry) {
    bool replaced = false;
    for (const std::string& variable : variables) {
      replaced = replaced || name_in(variable) == name_in(*entry);
    }
    if (!replaced) result.emplace_back(*entry);
  }
  return result;
}

/// The child's files and signals.
class SpawnPlan {
 public:
  explicit SpawnPlan(const std::string& log) {
    posix_spawn_file_actions_init(&files_);
    posix_spawn_file_actions_addopen(&files_, STDIN_FILENO, "/dev/null", O_RDONLY, 0);
    posix_spawn_file_actions_addopen(&files_, STDOUT_FILENO, log.c_str(),
                                     O_WRONLY | O_CREAT | O_TRUNC, 0600);
    posix_spawn_file_actions_adddup2(&files_, STDOUT_FILENO, STDERR_FILENO);
    posix_spawnattr_init(&attributes_);
    posix_spawnattr_setflags(&attributes_, POSIX_SPAWN_SETPGROUP | POSIX_SPAWN_SETSIGDEF);
    posix_spawnattr_setpgroup(&attributes_, 0);
    sigset_t signals;  // what this program ignores, its child would ignore, too
    sigemptyset(&signals);
    sigaddset(&signals, SIGPIPE);
    sigaddset(&signals, SIGXFSZ);
    posix_spawnattr_setsigdefault(&attributes_, &signals);
  }
  ~SpawnPlan() {
    posix_spawn_file_actions_destroy(&files_);
    posix_spawnattr_destroy(&attributes_);
  }
  SpawnPlan(const SpawnPlan&) = delete;
  SpawnPlan& operator=(const SpawnPlan&) = delete;

  pid_t spawn(std::vector<std::string> arguments, std::vector<std::string> environment) const {
    pid_t pid = 0;
    const auto argv = pointers_to(arguments);
    const auto envp = pointers_to(environment);
    const int error = posix_spawn(&pid, argv[0], &files_, &attributes_, argv.data(), envp.data());
    if (error != 0) {
      throw RunError("starting " + arguments[0] + ": " + std::generic_category().message(error));
    }
    return pid;
  }

 private:
  posix_spawn_file_actions_t files_{};
  posix_spawnattr_t attributes_{};
};

/// A running child; ended with its group when this goes.
class Child {
 public:
  explicit Child(pid_t pid) : pid_(pid) {}
  ~Child() {
    if (!ended_) end_group();
  }
  Child(const Child&) = delete;
  Child& operator=(const Child&) = delete;

  /// The exit status, if it ends within `limit`.
  std::optional<int> wait(Time limit, bool interruptible) {
    const SteadyClock clock;
    const Time end = clock.now() + limit;
    for (;;) {
      int status = 0;
      if (waitpid(pid_, &status, WNOHANG) == pid_) {
        ended_ = true;
        return WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
      }
      if (clock.now() >= end) return {};
      if (interruptible) check_interrupted();
      std::this_thread::sleep_for(milliseconds(5));
    }
  }

  /// mpirun, asked to end, ends its ranks, which are in groups of their own.
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

bool executable(const std::filesystem::path& file) {
  std::error_code ignored;
  return std::filesystem::is_regular_file(file, ignored) && access(file.c_str(), X_OK) == 0;
}

std::optional<std::filesystem::path> find_program(const std::string& name,
                                                  const std::string& path) {
  std::istringstream directories(path);
  for (std::string directory; std::getline(directories, directory, ':');) {
    const std::filesystem::path file =
        std::filesystem::path(directory.empty() ? "." : directory) / name;
    if (executable(file)) return std::filesystem::absolute(file);
  }
  return {};
}

ChildEnd run_child(const std::vector<std::string>& arguments,
                   const std::vector<std::string>& variables, const std::filesystem::path& log,
                   Time limit) {
  Child child(SpawnPlan(log.string()).spawn(arguments, environment_with(variables)));
  if (const auto status = child.wait(limit, true)) return {*status, false};
  child.end_group();
  return {0, true};
}

}  // namespace parray::child_process
