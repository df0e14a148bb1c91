#pragma once

namespace parray {

/// Makes SIGINT and SIGTERM set a flag instead of ending the process, and SIGPIPE do nothing. Call
/// once, first thing in main(). A second SIGINT or SIGTERM ends the process at once.
void catch_stop_signals();

/// True after SIGINT or SIGTERM. Any thread.
bool stop_requested();

}  // namespace parray
