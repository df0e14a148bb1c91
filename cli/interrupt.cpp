#include "cli/interrupt.h"

#include <unistd.h>

#include <array>
#include <atomic>
#include <csignal>
#include <string_view>

namespace parray {
namespace {

// The program's only global state: a signal handler takes no argument, so what it talks to has to
// be reachable without one. Lock-free atomics are what a handler may touch.
std::atomic<bool> deferred = false;
std::atomic<bool> noted = false;
static_assert(std::atomic<bool>::is_always_lock_free);

void on_signal(int /*signal*/) {
  noted = true;
  if (deferred) return;
  constexpr std::string_view text = "parray: interrupted\n";
  [[maybe_unused]] const auto written = write(STDERR_FILENO, text.data(), text.size());
  _exit(interrupted_status);
}

bool ignored(int signal) {
  struct sigaction current {};
  return sigaction(signal, nullptr, &current) == 0 && current.sa_handler == SIG_IGN;
}

}  // namespace

void install_signal_handlers() {
  struct sigaction action {};
  action.sa_handler = on_signal;
  sigemptyset(&action.sa_mask);
  for (const int signal : std::array{SIGINT, SIGTERM, SIGHUP}) {
    if (signal != SIGHUP || !ignored(signal)) sigaction(signal, &action, nullptr);
  }
  action.sa_handler = SIG_IGN;
  sigaction(SIGPIPE, &action, nullptr);
  sigaction(SIGXFSZ, &action, nullptr);
}

DeferredInterrupts::DeferredInterrupts() { deferred = true; }
DeferredInterrupts::~DeferredInterrupts() { deferred = false; }

bool interrupt_noted() { return noted; }

void check_interrupted() {
  if (interrupt_noted()) throw Interrupted();
}

}  // namespace parray
