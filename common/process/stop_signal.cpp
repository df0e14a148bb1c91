#include "common/process/stop_signal.h"

#include <sys/uio.h>
#include <unistd.h>

#include <array>
#include <atomic>
#include <csignal>
#include <cstring>

namespace parray::process {
namespace {

// The program's only global state. A signal handler takes no argument, so its data must be global.
// A handler may only use lock-free atomics.
std::atomic<bool> deferred = false;
std::atomic<bool> noted = false;
static_assert(std::atomic<bool>::is_always_lock_free);

void note(int /*signal*/) { noted = true; }

void stop(int /*signal*/) {
  noted = true;
  if (deferred) return;
  auto text = std::to_array(": interrupted\n");
  const std::array<iovec, 2> line{
      {{program_invocation_short_name, std::strlen(program_invocation_short_name)},
       {text.data(), text.size() - 1}}};
  [[maybe_unused]] const auto written = writev(STDERR_FILENO, line.data(), line.size());
  _exit(interrupted_status);
}

void handle(int signal, void (*handler)(int), int flags = 0) {
  struct sigaction action {};
  action.sa_handler = handler;
  action.sa_flags = flags;
  sigemptyset(&action.sa_mask);
  sigaction(signal, &action, nullptr);
}

bool ignored(int signal) {
  struct sigaction current {};
  return sigaction(signal, nullptr, &current) == 0 && current.sa_handler == SIG_IGN;
}

void ignore_failed_writes() {
  for (const int signal : std::array{SIGPIPE, SIGXFSZ}) handle(signal, SIG_IGN);
}

}  // namespace

void stop_at_signals() {
  for (const int signal : std::array{SIGINT, SIGTERM, SIGHUP}) {
    if (signal != SIGHUP || !ignored(signal)) handle(signal, stop);
  }
  ignore_failed_writes();
}

void ignore_signals() {
  for (const int signal : std::array{SIGINT, SIGTERM, SIGHUP}) handle(signal, SIG_IGN);
}

void note_signals() {
  constexpr int once = static_cast<int>(SA_RESETHAND);
  for (const int signal : std::array{SIGINT, SIGTERM}) handle(signal, note, once);
  ignore_failed_writes();
}

DeferredInterrupts::DeferredInterrupts() { deferred = true; }
DeferredInterrupts::~DeferredInterrupts() { deferred = false; }

bool interrupt_noted() { return noted; }

void check_interrupted() {
  if (interrupt_noted()) throw Interrupted();
}

}  // namespace parray::process
