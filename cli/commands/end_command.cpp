#include "cli/commands/end_command.h"

#include <cstdlib>
#include <iostream>

#include "common/base/printable.h"

namespace parray::commands {

void run_end_command(const std::string& command, JobId job, const std::string& state,
                     const std::string& reason, const std::string& image) {
  if (command.empty()) {
    return;
  }
  // One thread speaks for the user here; those that trace read no environment.
  // NOLINTBEGIN(concurrency-mt-unsafe)
  setenv("PARRAY_JOB", std::to_string(job).c_str(), 1);
  setenv("PARRAY_STATE", printable(state).c_str(), 1);
  setenv("PARRAY_REASON", printable(reason, 2000).c_str(), 1);
  setenv("PARRAY_IMAGE", image.c_str(), 1);
  const int status = std::system(command.c_str());  // NOLINT(cert-env33-c): the user's own command
  // NOLINTEND(concurrency-mt-unsafe)
  if (status != 0) {
    std::cerr << "parray: --on-end " << printable(command, 200) << " has failed\n";
  }
}

}  // namespace parray::commands
