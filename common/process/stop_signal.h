#pragma once

#include <stdexcept>
#include <string>

#include "common/rooms.h"

/// Handling of SIGINT and other signals. Programs always ignore SIGPIPE and SIGXFSZ, so a closed
/// pipe or a file-size limit is an error of the write.
namespace parray::process {

/// The user or the system has asked the program to stop. This is no failure: the program cleans up
/// and exits with interrupted_status.
class Interrupted : public std::runtime_error {
 public:
  /// `what`: one line for the user.
  explicit Interrupted(const std::string& what = "interrupted") : std::runtime_error(what) {}
};

/// Exit status after SIGINT, SIGTERM or SIGHUP.
inline constexpr int interrupted_status = 130;

/// For interactive programs: SIGINT, SIGTERM and SIGHUP end the program at once with one line on
/// stderr and interrupted_status. An ignored SIGHUP (nohup) stays ignored.
void stop_at_signals();

/// For services: SIGINT and SIGTERM set interrupt_noted(), which their loop reads. A second signal
/// ends the process at once.
void note_signals();

/// While an object exists, signals only set the note for check_interrupted(), because the work in
/// progress has to clean up or print something. Its owner calls check_interrupted() several times a
/// second. Do not nest.
class DeferredInterrupts {
 public:
  DeferredInterrupts();
  ~DeferredInterrupts();
  DeferredInterrupts(const DeferredInterrupts&) = delete;
  DeferredInterrupts& operator=(const DeferredInterrupts&) = delete;
};

/// Whether a signal has arrived. Any thread.
bool interrupt_noted();
/// Throws Interrupted if a signal has arrived. Any thread.
void check_interrupted();

}  // namespace parray::process
