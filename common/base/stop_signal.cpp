#include "common/base/stop_signal.h"

#include <atomic>
#include <csignal>

namespace parray {
namespace {

// The one global variable: a signal handler can reach nothing else.
std::atomic<bool> stop = false;
static_assert(std::atomic<bool>::is_always_lock_free, "a signal handler may not lock");

extern "C" void on_stop_signal(int /*signal*/) { stop = true; }

void handle(int signal, void (*handler)(int), int flags) {
  struct sigaction action {};
  action.sa_handler = handler;
  action.sa_flags = flags;
  sigemptyset(&action.sa_mask);
  sigaction(signal, &action, nullptr);
}

}  // namespace

void catch_stop_signals() {
  constexpr int once = static_cast<int>(SA_RESETHAND);
  handle(SIGINT, on_stop_signal, once);
  handle(SIGTERM, on_stop_signal, once);
  handle(SIGPIPE, SIG_IGN, 0);
}

bool stop_requested() { return stop; }

}  // namespace parray
