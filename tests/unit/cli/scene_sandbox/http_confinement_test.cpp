#include <doctest/doctest.h>
#include <linux/landlock.h>
#include <sched.h>
#include <sys/resource.h>
#include <sys/syscall.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <filesystem>
#include <fstream>
#include <string>

#include "cli/scene_sandbox/confinement.h"
#include "tests/support/rooms.h"
#include "tests/support/temporary_directory.h"

namespace parray {
namespace {

namespace fs = std::filesystem;

bool kernel_knows_landlock() {
  return syscall(SYS_landlock_create_ruleset, nullptr, 0, LANDLOCK_CREATE_RULESET_VERSION) >= 1;
}

/// The exit status of a process that does `work`.
template <typename Work>
int status_of_process(const Work& work) {
  const pid_t child = fork();
  if (child == 0) _exit(work());
  int status = -1;
  waitpid(child, &status, 0);
  return WIFEXITED(status) ? WEXITSTATUS(status) : -1;
}

struct Rooms {
  Rooms() {
    fs::create_directories(inside);
    fs::create_directories(outside);
    std::ofstream(outside / "secret") << "secret";
  }
  test::TemporaryDirectory directory;
  fs::path inside = directory.path() / "inside";
  fs::path outside = directory.path() / "outside";
};

TEST_CASE("all forbidden actions succeed in a process that is not enclosed") {
  const Rooms rooms;
  CHECK(ways_out({rooms.inside, 1000}, rooms.outside / "secret").size() == 7);
}

TEST_CASE("all forbidden actions fail in an enclosed process, and it can use its own directory") {
  if (PARRAY_SANITIZED || !kernel_knows_landlock()) return;
  const Rooms rooms;
  const Enclosure enclosure{rooms.inside, 1000};
  CHECK(status_of_process([&] {
          enclose_process(enclosure);
          return static_cast<int>(ways_out(enclosure, rooms.outside / "secret").size());
        }) == 0);
  CHECK(status_of_process([&] {
          enclose_process(enclosure);
          std::ofstream(rooms.inside / "file") << "text";
          std::string text;
          std::ifstream(rooms.inside / "file") >> text;
          return text == "text" ? 0 : 1;
        }) == 0);
}

TEST_CASE("an enclosed process has power over itself only") {
  if (PARRAY_SANITIZED) return;
  const Rooms rooms;
  const auto refused = [](long result) { return result == -1 && errno == EPERM; };
  CHECK(status_of_process([&] {
          enclose_process({rooms.inside, 1000});
          const pid_t parent = getppid();
          rlimit own{};
          cpu_set_t processors;
          CPU_ZERO(&processors);
          const bool for_itself = prlimit(0, RLIMIT_CPU, nullptr, &own) == 0 &&
                                  prlimit(getpid(), RLIMIT_CPU, nullptr, &own) == 0 &&
                                  syscall(SYS_tgkill, getpid(), getpid(), 0) == 0;
          const bool for_others =
              !refused(syscall(SYS_tgkill, parent, parent, 0)) ||
              !refused(prlimit(parent, RLIMIT_CPU, nullptr, &own)) ||
              !refused(setpriority(PRIO_PROCESS, static_cast<id_t>(parent), 19)) ||
              !refused(sched_setaffinity(parent, sizeof processors, &processors));
          return for_itself && !for_others ? 0 : 1;
        }) == 0);
}

TEST_CASE(
    "an enclosed process cannot start processes or make hard links to files that it may not read") {
  if (PARRAY_SANITIZED || !kernel_knows_landlock()) return;
  const Rooms rooms;
  CHECK(status_of_process([&] {
          enclose_process({rooms.inside, 1000});
          if (fork() >= 0) return 1;
          execl("/bin/true", "true", nullptr);  // it would end with status 0
          const int linked = link((rooms.outside / "secret").c_str(), (rooms.inside / "l").c_str());
          return linked == 0 ? 2 : 3;
        }) == 3);
}

}  // namespace
}  // namespace parray
