#include "common/process/run_main.h"

#include <malloc.h>
#include <sys/resource.h>

#include <algorithm>
#include <exception>
#include <iostream>
#include <new>
#include <optional>
#include <string_view>

#include "common/base/error.h"
#include "common/process/command_line.h"
#include "common/process/description.h"
#include "common/process/stop_signal.h"

namespace parray::process {

namespace {

/// glibc reserves 64 to 128 MiB of addresses for the heap of each thread. Under `ulimit -v` the
/// stack may then be unable to grow, which ends the process by SIGSEGV. In that case all threads
/// share one heap.
void use_one_heap_under_a_limit() {
  rlimit addresses{};
  if (getrlimit(RLIMIT_AS, &addresses) == 0 && addresses.rlim_cur != RLIM_INFINITY) {
    mallopt(M_ARENA_MAX, 1);  // NOLINT(concurrency-mt-unsafe): no other thread runs yet
  }
}

}  // namespace

int fail(const char* program, int status, std::string message) {
  std::replace(message.begin(), message.end(), '\n', ' ');
  // Printed in one piece: mpirun, for example, mixes partial output with that of other processes.
  std::cerr << std::string(program) + ": " + message + "\n" << std::flush;
  return status;
}

int run_action(const char* program, const Action& action) {
  try {
    const int status = action();
    std::cout.flush();
    return std::cout || status != 0 ? status
                                    : fail(program, 1, "writing to standard output failed");
  } catch (const InputError& error) {
    return fail(program, 2, error.what());
  } catch (const RunError& error) {
    return fail(program, 1, error.what());
  } catch (const Interrupted& interrupted) {
    return fail(program, interrupted_status, interrupted.what());
  } catch (const std::bad_alloc&) {
    return fail(program, 1, "out of memory");
  } catch (const std::exception& error) {
    return fail(program, 1, std::string("internal error: ") + error.what());
  }
}

int run_main(const Program& program, int argc, const char* const* argv,
             const std::function<Action(CommandLine&)>& declare) {
  use_one_heap_under_a_limit();
  try {
    const auto declare_all = [&](CommandLine& line) {
      line.launcher(program.launcher);
      Action action = declare(line);
      line.version(program.version);
      return action;
    };
    constexpr std::string_view json = "json";
    if (argc == 3 && std::string_view(argv[1]) == "--describe" && argv[2] == json) {
      return run_action(program.name, [&] {
        std::cout << describe(declare_all, program.name, program.about);
        return 0;
      });
    }
    CommandLine line(program.about, program.name);
    const Action action = declare_all(line);
    try {
      if (const std::optional<std::string> asked = line.parse(argc, argv)) {
        if (!program.speaks) return 0;
        return run_action(program.name, [&] {
          std::cout << *asked;
          return 0;
        });
      }
    } catch (const UsageError& error) {
      return program.speaks ? fail(program.name, 2, error.what()) : 0;
    }
    return run_action(program.name, action);
  } catch (...) {  // even making the message failed
    return 1;
  }
}

}  // namespace parray::process
