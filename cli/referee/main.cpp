// parray-referee: traces cells again for a coordinator, to decide disputes and to check results.
// Only the coordinator starts it (coordinator/disputes/referee_process.h). Its standard input is a
// socket. It sends `hello`, then answers each `grant` with `result` or `failed`. Frames that begin
// with "scene" contain the scene of the following grants.
#include <sys/prctl.h>
#include <sys/resource.h>
#include <unistd.h>

#include <atomic>
#include <cerrno>
#include <csignal>
#include <ctime>
#include <memory>
#include <new>
#include <optional>
#include <string>
#include <system_error>

#include "common/base/error.h"
#include "common/math/float_mode.h"
#include "common/process/command_line.h"
#include "common/process/run_main.h"
#include "common/scene/settings_fwd.h"
#include "common/trace/selfcheck/fingerprint.h"
#include "proto/messages.h"
#include "proto/stream_frames.h"
#include "worker/accelerator_cache.h"
#include "worker/cell_tracer.h"

namespace {

using namespace parray::referee;

constexpr Program program = {"parray-referee",
                             "Trace cells again for a coordinator, which starts this program",
                             PARRAY_VERSION};

constexpr int socket_of_the_coordinator = STDIN_FILENO;

/// Sets a limit of this process. `name` is the name of the limit, for people.
void limit(decltype(RLIMIT_AS) what, const char* name, rlim_t value) {
  const rlimit wanted{value, value};
  if (setrlimit(what, &wanted) != 0) {
    throw RunError("limiting the " + std::string(name) + " of this process to " +
                   std::to_string(value) + " bytes failed (" +
                   std::generic_category().message(errno) +
                   "): raise the coordinator's hard limit (ulimit -H -v)");
  }
}

/// Ends this process with the coordinator, sets the lowest priority, and limits the address space
/// to `memory` bytes.
void confine([[maybe_unused]] std::uint64_t memory) {
  prctl(PR_SET_PDEATHSIG, SIGKILL);
  prctl(PR_SET_NO_NEW_PRIVS, 1, 0, 0, 0);
  constexpr int lowest = 19;
  setpriority(PRIO_PROCESS, 0, lowest);
  limit(RLIMIT_CORE, "core file", 0);
#ifndef PARRAY_SANITIZED  // the shadow memory of sanitizers needs a huge address space
  limit(RLIMIT_AS, "address space", memory);
#endif
}

double processor_seconds() {
  timespec used{};
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &used);
  return static_cast<double>(used.tv_sec) + 1e-9 * static_cast<double>(used.tv_nsec);
}

class RefereeProgram {
 public:
  /// Serves until the coordinator closes the socket. Throws RunError if it cannot send.
  void serve() {
    msg::Hello hello;
    hello.name = "referee";
    hello.instance = std::to_string(getpid());
    hello.fingerprint = trace_fingerprint();
    send(hello);
    constexpr std::uint64_t most_bytes = std::uint64_t{1} << 40;
    while (auto frames = read_frames(socket_of_the_coordinator, most_bytes)) {
      if (!frames->empty() && frames->front().view() == "scene") {
        take_scene(std::move(*frames));
        continue;
      }
      const Message message = decode(*frames);
      if (const auto* grant = std::get_if<msg::Grant>(&message)) answer(*grant);
    }
  }

 private:
  static void send(const Message& message) {
    if (!write_frames(socket_of_the_coordinator, encode(message))) {
      throw RunError("the coordinator has closed the connection");
    }
  }

  void take_scene(Frames frames) {
    scene_.reset();
    failure_.clear();
    try {
      const ScenePayload payload(Bulk::of(std::move(frames.at(1))));
      scene_id_ = payload.identity();
      scene_ = payload.scene();
    } catch (const std::bad_alloc&) {
      failure_ = "not enough memory for the scene";
    } catch (const std::exception& error) {
      failure_ = error.what();
    }
  }

  void answer(const msg::Grant& grant) {
    const double began = reported_;
    msg::Failed failed{grant.job, grant.epoch, failure_};
    std::optional<msg::Result> result;
    try {
      if (scene_ && scene_id_ == grant.scene) {
        result = trace(grant);
      } else if (failed.reason.empty()) {
        failed.reason = "the scene has not arrived";
      }
    } catch (const std::bad_alloc&) {
      failed.reason = "not enough memory to trace the scene";
    } catch (const std::exception& error) {
      failed.reason = error.what();
    }
    reported_ = processor_seconds();
    if (!result) return send(failed);
    result->seconds = reported_ - began;
    send(*result);
  }

  msg::Result trace(const msg::Grant& grant) {
    const FloatMode ieee;
    auto accelerator = accelerators_.find(scene_id_, grant.settings);
    if (!accelerator) accelerator = accelerators_.build(scene_id_, *scene_, grant.settings, 1);
    const auto tracer = make_path_tracer(accelerator, scene_->camera, picture_of(grant.settings));
    std::atomic<std::uint64_t> count = 0;
    msg::Result result;
    result.job = grant.job;
    result.epoch = grant.epoch;
    result.accelerator_bytes = accelerator->bytes();
    result.isa = tracer->isa();
    result.grid = grant.cells.grid;
    result.cells = CellsPayload(
        std::make_shared<const TracedCells>(trace_cells(*tracer, grant.cells, 1, count, false)));
    return result;
  }

  std::string scene_id_;
  std::shared_ptr<const Scene> scene_;
  std::string failure_;  ///< why there is no scene
  AcceleratorCache accelerators_;
  double reported_ = 0;  ///< processor time, in seconds, that earlier answers contain
};

}  // namespace

int main(int argc, char** argv) {
  std::size_t memory = 0;
  return run_main(program, argc, argv, [&](CommandLine& line) -> Action {
    line.number("--memory", memory, 1, std::size_t{1} << 50, "Bytes of address space").required();
    return [&memory] {
      confine(memory);
      RefereeProgram().serve();
      return 0;
    };
  });
}
