#include "coordinator/http/child.h"

#include <sys/resource.h>

#include <cerrno>
#include <csignal>
#include <fstream>
#include <system_error>
#include <thread>

#include "common/base/error.h"

namespace parray::http {
namespace {

namespace fs = std::filesystem;

std::string last_line(const fs::path& file) {
  std::ifstream in(file);
  std::string last;
  for (std::string line; std::getline(in, line);) {
    if (!line.empty()) last = line;
  }
  return last;
}

}  // namespace

OwnedPath work_directory(const fs::path& parent) {
  fs::path path = make_directory(parent / "request-");
  if (path.empty()) {
    throw RunError("creating a directory in " + parent.string() +
                   " failed: " + std::generic_category().message(errno));
  }
  return OwnedPath(std::move(path));
}

ChildRunner::ChildRunner() : program_(helper_program("parray-http-child")) {
  if (!executable(program_)) {
    throw RunError("--http: " + program_.string() +
                   " is missing: install the package parray, or install ParRay again");
  }
}

ChildEnd ChildRunner::run(const std::vector<std::string>& wanted, const fs::path& directory,
                          const ChildLimits& limits) const {
  if (stopped_) throw RunError("the coordinator is stopping");
  std::vector<std::string> arguments = wanted;
  arguments.insert(arguments.begin(),
                   {program_.string(), "--memory=" + std::to_string(limits.memory),
                    "--seconds=" + std::to_string(limits.seconds)});
  const fs::path messages = directory.parent_path() / (directory.filename().string() + ".messages");
  const pid_t child = start_child({.arguments = std::move(arguments),
                                   .environment = helper_environment(2),
                                   .messages = messages,
                                   .directory = directory});
  constexpr int low_priority = 5;
  setpriority(PRIO_PROCESS, static_cast<id_t>(child), low_priority);
  const SteadyClock clock;
  const Time end_at = clock.now() + seconds(elapsed_seconds(limits));
  bool timed_out = false;
  std::optional<ChildEnd> found;
  while (!(found = end_of_child(child))) {
    if (!timed_out && (stopped_ || clock.now() >= end_at)) {
      timed_out = true;
      kill(-child, SIGKILL);
    }
    std::this_thread::sleep_for(milliseconds(2));
  }
  kill(-child, SIGKILL);  // kills processes that the child has left behind
  ChildEnd end = std::move(*found);
  end.timed_out = timed_out || end.signal == SIGXCPU;
  constexpr std::string_view program = "parray: ";
  end.message = last_line(messages);
  if (end.message.starts_with(program)) end.message.erase(0, program.size());
  std::error_code ignored;
  fs::remove(messages, ignored);
  if (timed_out && stopped_) throw RunError("the coordinator is stopping");
  return end;
}

}  // namespace parray::http
