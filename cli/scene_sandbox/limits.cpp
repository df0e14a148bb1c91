#include "cli/scene_sandbox/limits.h"

#include <sys/prctl.h>
#include <sys/resource.h>

#include <csignal>
#include <optional>
#include <utility>

#include "common/base/error.h"
#include "common/base/files.h"

namespace parray::scene_sandbox {
namespace {

/// `option` is the option of the coordinator that gives the limit. `beyond`: the distance from the
/// soft limit `value` to the hard limit.
void limit(decltype(RLIMIT_AS) what, rlim_t value, const std::string& option, rlim_t beyond = 0) {
  const rlimit wanted{value, value + beyond};
  if (setrlimit(what, &wanted) != 0) {
    throw RunError("the coordinator's own limits (ulimit -H -a) are below " + option +
                   ": start it with higher limits, or lower the option");
  }
}

}  // namespace

Enclosure enclosure_of(std::uint64_t file_bytes) {
  return {std::filesystem::current_path().parent_path(), file_bytes};
}

void confine(const ChildResources& resources, std::uint64_t file_bytes) {
  prctl(PR_SET_PDEATHSIG, SIGKILL);
  prctl(PR_SET_DUMPABLE, 0);
  limit(RLIMIT_CORE, 0, "0 for core files");
  // At the soft limit the kernel sends SIGXCPU, which names the reason. The hard limit kills.
  limit(RLIMIT_CPU, resources.seconds, "--http-scene-seconds", 1);
#ifndef PARRAY_SANITIZED  // the shadow memory of sanitizers needs a huge address space
  limit(RLIMIT_AS, resources.memory, "--http-scene-memory");
  enclose_process(enclosure_of(file_bytes));
#else
  static_cast<void>(file_bytes);
#endif
}

void keep_bytes(const std::filesystem::path& file, std::string_view bytes) {
  if (!write_file(file, bytes)) {
    throw RunError("the coordinator cannot write the temporary file " + file.filename().string() +
                   ", perhaps because the disk is full: make room on the disk of --state or, "
                   "without --state, of TMPDIR");
  }
}

std::string kept_bytes(const std::filesystem::path& file) {
  std::optional<std::string> bytes = read_file(file);
  if (!bytes) throw RunError("reading " + file.string() + " failed");
  return *std::move(bytes);
}

}  // namespace parray::scene_sandbox
