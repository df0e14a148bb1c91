#include "cli/output/picture/partial_file.h"

#include <doctest/doctest.h>
#include <unistd.h>

#include <array>
#include <atomic>
#include <csignal>
#include <cstdio>
#include <thread>

#include "tests/support/rooms.h"
#include "tests/support/temporary_directory.h"

namespace parray::test {
namespace {

std::array<char, 500> trial{};  ///< path of the file that a check creates
std::atomic<int> signals = 0;
std::atomic<int> left_behind = 0;

/// Counts the signals, and those at which the trial file exists. A handler that ended the program
/// then would leave the file behind.
void look_for_trial(int /*signal*/) {
  ++signals;
  if (access(trial.data(), F_OK) == 0) ++left_behind;
}

TEST_CASE("a signal finds no file of a check whether files can be created") {
  const TemporaryDirectory directory;
  static_cast<void>(std::snprintf(trial.data(), trial.size(), "%s",
                                  PartialFile(directory.path() / "a.png").path().c_str()));
  struct sigaction action {};
  struct sigaction before {};
  action.sa_handler = look_for_trial;
  sigaction(SIGUSR2, &action, &before);
  const pthread_t checking = pthread_self();
  std::atomic<bool> over = false;
  std::thread disturber([&] {
    while (!over) {
      pthread_kill(checking, SIGUSR2);
      std::this_thread::yield();
    }
  });
  while (signals < 1000) check_output_path(directory.path() / "a.png");
  over = true;
  disturber.join();
  sigaction(SIGUSR2, &before, nullptr);
  CHECK(left_behind == 0);
}

}  // namespace
}  // namespace parray::test
