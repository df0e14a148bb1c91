#include "coordinator/http/child.h"

#include <fcntl.h>
#include <spawn.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <csignal>
#include <fstream>
#include <system_error>
#include <thread>

#include "common/base/error.h"
#include "common/base/printable.h"
#include "coordinator/loop/helper_program.h"

namespace parray::http {
namespace {

namespace fs = std::filesystem;

fs::path find_child() {
  fs::path program = helper_program("parray-http-child");
  if (access(program.c_str(), X_OK) != 0) {
    throw RunError("--http: " + program.string() +
                   " is not there: install the package parray, or ParRay again");
  }
  return program;
}

std::string last_line(const fs::path& file) {
  std::ifstream in(file);
  std::string last;
  for (std::string line; std::getline(in, line);) {
    if (!line.empty()) last = line;
  }
  return last;
}

class Spawned {
 public:
  Spawned(std::vector<std::string> arguments, const fs::path& directory, const fs::path& messages) {
    posix_spawn_file_actions_t files;
    posix_spawn_file_actions_init(&files);
    posix_spawn_file_actions_addopen(&files, STDIN_FILENO, "/dev/null", O_RDONLY, 0);
    posix_spawn_file_actions_addopen(&files, STDOUT_FILENO, "/dev/null", O_WRONLY, 0);
    posix_spawn_file_actions_addopen(&files, STDERR_FILENO, messages.c_str(), O_WRONLY | O_CREAT,
                                     0600);
    posix_spawn_file_actions_addclosefrom_np(&files, STDERR_FILENO + 1);
    posix_spawn_file_actions_addchdir_np(&files, directory.c_str());
    try {
      pid_ = start_helper(std::move(arguments), files, 2);
    } catch (...) {
      posix_spawn_file_actions_destroy(&files);
      throw;
    }
    posix_spawn_file_actions_destroy(&files);
    constexpr int low = 5;
    setpriority(PRIO_PROCESS, static_cast<id_t>(pid_), low);
  }

  void kill_all() const { kill(-pid_, SIGKILL); }

  /// True once it has ended.
  bool ended(ChildEnd& end) const {
    int status = 0;
    const pid_t found = waitpid(pid_, &status, WNOHANG);
    if (found == 0) return false;
    end.status = found == pid_ && WIFEXITED(status) ? WEXITSTATUS(status) : -1;
    end.signal = found == pid_ && WIFSIGNALED(status) ? WTERMSIG(status) : 0;
    end.timed_out = end.timed_out || end.signal == SIGXCPU;
    return true;
  }

 private:
  pid_t pid_ = 0;
};

}  // namespace

WorkDirectory::WorkDirectory(const fs::path& parent) {
  std::string name = (parent / "request-XXXXXX").string();
  if (mkdtemp(name.data()) == nullptr) {
    throw RunError("making a directory in " + parent.string() + ": " +
                   std::generic_category().message(errno));
  }
  path_ = name;
}

WorkDirectory::~WorkDirectory() {
  std::error_code ignored;
  fs::remove_all(path_, ignored);
}

ChildRunner::ChildRunner() : program_(find_child()) {}

ChildEnd ChildRunner::run(const std::vector<std::string>& wanted, const fs::path& directory,
                          const ChildLimits& limits) const {
  if (stopped_) throw RunError("the coordinator is stopping");
  std::vector<std::string> arguments = wanted;
  arguments.insert(arguments.begin(),
                   {program_.string(), "--memory=" + std::to_string(limits.memory),
                    "--seconds=" + std::to_string(limits.seconds)});
  const fs::path messages = directory.parent_path() / (directory.filename().string() + ".messages");
  const Spawned child(std::move(arguments), directory, messages);
  const SteadyClock clock;
  const Time end_at = clock.now() + seconds(2 * limits.seconds);
  ChildEnd end;
  while (!child.ended(end)) {
    if (!end.timed_out && (stopped_ || clock.now() >= end_at)) {
      end.timed_out = true;
      child.kill_all();
    }
    std::this_thread::sleep_for(milliseconds(2));
  }
  child.kill_all();  // of its group nobody stays
  constexpr std::string_view program = "parray: ";
  end.message = last_line(messages);
  if (end.message.starts_with(program)) end.message.erase(0, program.size());
  std::error_code ignored;
  fs::remove(messages, ignored);
  return end;
}

}  // namespace parray::http
