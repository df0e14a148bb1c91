#pragma once

#include <stdexcept>
#include <string>

#include "common/rooms.h"

/// Handling of SIGINT and similar signals. stop_at_signals() and note_signals() also ignore SIGPIPE
/// and SIGXFSZ. So a closed pipe and a file-size limit become errors of the call that meets them.
namespace parray::process {

/// Thrown if the user or the system has asked the program to stop. It is not a failure: the program
/// cleans up and exits with interrupted_status.
class Interrupted : public std::runtime_error {
 public:
  /// `what`: one line for the user.
  explicit Interrupted(const std::string& what = "interrupted") : std::runtime_error(what) {}
};

/// The exit status of a program that SIGINT, SIGTERM or SIGHUP interrupted.
inline constexpr int interrupted_status = 130;

/// For interactive programs. From now on SIGINT, SIGTERM and SIGHUP end the program at once with
/// one line on stderr and interrupted_status. If SIGHUP is ignored (nohup), it stays ignored.
void stop_at_signals();

/// Makes SIGINT, SIGTERM and SIGHUP do nothing from now on. An interactive program calls this when
/// its last output is in place. Then a late signal does not change its exit status.
void ignore_signals();

/// For services, which poll interrupt_noted() in their loop. From now on SIGINT and SIGTERM are
/// only noted; the second signal of the same kind ends the process at once. Does not change what
/// SIGHUP does.
void note_signals();

/// While an object exists, the signals of stop_at_signals() do not end the program, however often
/// they arrive. They are only noted, because the current operation must clean up or report
/// something. The owner of the object calls check_interrupted() several times a second. After the
/// destructor, only new signals end the program. Objects must not be nested.
class DeferredInterrupts {
 public:
  DeferredInterrupts();
  ~DeferredInterrupts();
  DeferredInterrupts& operator=(DeferredInterrupts&&) = delete;
};

/// Returns whether one of the signals above has arrived since the program began. Thread-safe.
bool interrupt_noted();
/// Throws Interrupted if interrupt_noted(). Thread-safe.
void check_interrupted();

}  // namespace parray::process
