#pragma once

#include <stdexcept>
#include <string>

#include "common/rooms.h"

/// What a program does about SIGINT and the like. Ignored in any case are SIGPIPE and SIGXFSZ, so
/// that a closed pipe and a file-size limit are errors where they happen.
namespace parray::process {

/// The user, or the system, has asked the program to stop. Not a failure: the program cleans up
/// and exits with interrupted_status.
class Interrupted : public std::runtime_error {
 public:
  /// `what`: one line for the user.
  explicit Interrupted(const std::string& what = "interrupted") : std::runtime_error(what) {}
};

/// Exit status after SIGINT, SIGTERM or SIGHUP.
inline constexpr int interrupted_status = 130;

/// For programs that a person waits for: SIGINT, SIGTERM and SIGHUP end the program at once with
/// one line on stderr and interrupted_status; SIGHUP only where it is not ignored (nohup).
void stop_at_signals();

/// For services, whose loop asks interrupt_noted(): SIGINT and SIGTERM leave a note; a second one
/// ends the process at once.
void note_signals();

/// While one exists, stop_at_signals() only leaves a note, too, for check_interrupted(): what is
/// under way has something to clean up or to say. Its owner calls check_interrupted() several times
/// a second. Do not nest.
class DeferredInterrupts {
 public:
  DeferredInterrupts();
  ~DeferredInterrupts();
  DeferredInterrupts(const DeferredInterrupts&) = delete;
  DeferredInterrupts& operator=(const DeferredInterrupts&) = delete;
};

/// A signal has come. Any thread.
bool interrupt_noted();
/// Throws Interrupted if a signal has come. Any thread.
void check_interrupted();

}  // namespace parray::process
