#include "coordinator/loop/helper_program.h"

#include <csignal>
#include <cstdlib>
#include <system_error>

#include "common/base/error.h"

namespace parray::coordinator {
namespace {

std::vector<char*> pointers_to(std::vector<std::string>& texts) {
  std::vector<char*> pointers;
  pointers.reserve(texts.size() + 1);
  for (std::string& text : texts) pointers.push_back(text.data());
  pointers.push_back(nullptr);
  return pointers;
}

/// Threads reserve address space that they never use: few of them, and few arenas.
std::vector<std::string> environment(int threads) {
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

}  // namespace

std::filesystem::path helper_program(const std::string& name) {
  std::error_code error;
  const std::filesystem::path self = std::filesystem::read_symlink("/proc/self/exe", error);
  return self.parent_path().parent_path() / "lib" / "parray" / name;
}

pid_t start_helper(std::vector<std::string> arguments, const posix_spawn_file_actions_t& files,
                   int threads) {
  posix_spawnattr_t attributes;
  posix_spawnattr_init(&attributes);
  posix_spawnattr_setflags(&attributes, POSIX_SPAWN_SETPGROUP | POSIX_SPAWN_SETSIGDEF);
  posix_spawnattr_setpgroup(&attributes, 0);
  sigset_t signals;  // what this program ignores, its child would ignore, too
  sigfillset(&signals);
  posix_spawnattr_setsigdefault(&attributes, &signals);
  std::vector<std::string> variables = environment(threads);
  const auto argv = pointers_to(arguments);
  const auto envp = pointers_to(variables);
  pid_t process = 0;
  const int error = posix_spawn(&process, argv[0], &files, &attributes, argv.data(), envp.data());
  posix_spawnattr_destroy(&attributes);
  if (error != 0) {
    throw RunError("starting " + arguments[0] + ": " + std::generic_category().message(error));
  }
  return process;
}

}  // namespace parray::coordinator
