#include "common/process/child.h"

#include <fcntl.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <csignal>
#include <cstdlib>
#include <sstream>
#include <string_view>
#include <system_error>

#include "common/base/error.h"

namespace parray::process {
namespace {

namespace fs = std::filesystem;

/// Returns pointers to `texts` with a null pointer at the end, as posix_spawn needs them. `texts`
/// must not move.
std::vector<char*> pointers_to(std::vector<std::string>& texts) {
  std::vector<char*> pointers;
  pointers.reserve(texts.size() + 1);
  for (std::string& text : texts) pointers.push_back(text.data());
  pointers.push_back(nullptr);
  return pointers;
}

/// The open files and the signal handling of a child.
class SpawnPlan {
 public:
  explicit SpawnPlan(const ChildSetup& setup) {
    posix_spawn_file_actions_init(&files_);
    if (setup.input >= 0) {
      posix_spawn_file_actions_adddup2(&files_, setup.input, STDIN_FILENO);
    } else {
      posix_spawn_file_actions_addopen(&files_, STDIN_FILENO, "/dev/null", O_RDONLY, 0);
    }
    open(STDOUT_FILENO, setup.output.empty() ? "/dev/null" : setup.output);
    if (!setup.messages.empty() && setup.messages == setup.output) {
      posix_spawn_file_actions_adddup2(&files_, STDOUT_FILENO, STDERR_FILENO);
    } else if (!setup.messages.empty()) {
      open(STDERR_FILENO, setup.messages);
    }
    posix_spawn_file_actions_addclosefrom_np(&files_, STDERR_FILENO + 1);
    if (!setup.directory.empty()) {
      posix_spawn_file_actions_addchdir_np(&files_, setup.directory.c_str());
    }
    posix_spawnattr_init(&attributes_);
    posix_spawnattr_setflags(&attributes_, POSIX_SPAWN_SETPGROUP | POSIX_SPAWN_SETSIGDEF);
    posix_spawnattr_setpgroup(&attributes_, 0);
    sigset_t signals;  // a child inherits the signals that this process ignores
    sigfillset(&signals);
    posix_spawnattr_setsigdefault(&attributes_, &signals);
  }
  ~SpawnPlan() {
    posix_spawn_file_actions_destroy(&files_);
    posix_spawnattr_destroy(&attributes_);
  }
  SpawnPlan& operator=(SpawnPlan&&) = delete;

  pid_t spawn(std::vector<std::string>& arguments, std::vector<std::string>& environment) const {
    pid_t child = 0;
    const auto argv = pointers_to(arguments);
    const auto envp = pointers_to(environment);
    const int error = posix_spawn(&child, argv[0], &files_, &attributes_, argv.data(), envp.data());
    if (error != 0) {
      throw RunError("starting " + arguments[0] + ": " + std::generic_category().message(error));
    }
    return child;
  }

 private:
  void open(int descriptor, const fs::path& file) {
    posix_spawn_file_actions_addopen(&files_, descriptor, file.c_str(),
                                     O_WRONLY | O_CREAT | O_TRUNC, 0600);
  }

  posix_spawn_file_actions_t files_{};
  posix_spawnattr_t attributes_{};
};

std::string_view name_in(std::string_view variable) {
  return variable.substr(0, variable.find('='));
}

}  // namespace

pid_t start_child(ChildSetup setup) {
  return SpawnPlan(setup).spawn(setup.arguments, setup.environment);
}

std::optional<ChildEnd> end_of_child(pid_t child) {
  int status = 0;
  const pid_t found = waitpid(child, &status, WNOHANG);
  if (found == 0) return std::nullopt;
  ChildEnd end;
  end.signal = found == child && WIFSIGNALED(status) ? WTERMSIG(status) : 0;
  end.status = found == child && WIFEXITED(status) ? WEXITSTATUS(status) : 128 + end.signal;
  return end;
}

std::vector<std::string> environment_with(const std::vector<std::string>& variables) {
  std::vector<std::string> result = variables;
  for (char** entry = environ; *entry != nullptr; ++entry) {
    const bool replaced = std::ranges::any_of(variables, [&](const std::string& variable) {
      return name_in(variable) == name_in(*entry);
    });
    if (!replaced) result.emplace_back(*entry);
  }
  return result;
}

std::vector<std::string> helper_environment(int threads) {
  const std::string few = std::to_string(threads);
  std::vector<std::string> variables = {"OMP_NUM_THREADS=" + few, "MALLOC_ARENA_MAX=" + few,
                                        "LC_ALL=C"};
  for (const char* const name : {"PATH", "LD_LIBRARY_PATH", "ASAN_OPTIONS", "LSAN_OPTIONS"}) {
    // NOLINTNEXTLINE(concurrency-mt-unsafe): nothing changes the environment
    if (const char* const value = getenv(name); value != nullptr) {
      variables.push_back(std::string(name) + "=" + value);
    }
  }
  return variables;
}

fs::path helper_program(const std::string& name) {
  std::error_code error;
  const fs::path self = fs::read_symlink("/proc/self/exe", error);
  return self.parent_path().parent_path() / "lib" / "parray" / name;
}

bool executable(const fs::path& file) {
  std::error_code ignored;
  return fs::is_regular_file(file, ignored) && access(file.c_str(), X_OK) == 0;
}

std::optional<fs::path> find_program(const std::string& name, const std::string& path) {
  std::istringstream directories(path);
  for (std::string directory; std::getline(directories, directory, ':');) {
    const fs::path file = fs::path(directory.empty() ? "." : directory) / name;
    if (executable(file)) return fs::absolute(file);
  }
  return {};
}

}  // namespace parray::process
