#pragma once

#include <functional>
#include <string>

namespace parray {

/// Prints "PROGRAM: message" as one line on stderr; returns `status`.
int fail(const char* program, int status, std::string message);

/// `status`, unless what was printed has not arrived: a full disk behind stdout is a failure, too.
int checked_output(const char* program, int status);

/// Does `action` and returns the exit status; what it throws becomes a line on stderr and the
/// status that its type stands for.
int run_action(const char* program, const std::function<int()>& action);

}  // namespace parray
