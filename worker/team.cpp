#include "worker/team.h"

#include <new>
#include <stdexcept>

#include "common/base/printable.h"
#include "common/scene/settings_fwd.h"
#include "proto/clock.h"
#include "worker/cell_tracer.h"

namespace parray::worker {
namespace {

/// Longest reason of a failure, in bytes: one line.
constexpr std::size_t longest_reason = 200;

}  // namespace

ThreadTeam::ThreadTeam(int threads, std::function<void()> on_finished,
                       std::shared_ptr<AcceleratorCache> accelerators, TracerSource tracers)
    : threads_(threads),
      accelerators_(std::move(accelerators)),
      tracers_(std::move(tracers)),
      thread_([this](const LeaseWork& assignment,
                     const std::atomic<bool>& stop) { return trace(assignment, stop); },
              std::move(on_finished)) {}

std::shared_ptr<const PathTracer> ThreadTeam::tracer_for(const LeaseWork& assignment) {
  if (tracers_) return tracers_(assignment, threads_);
  auto accelerator = accelerators_->find(assignment.scene_id, assignment.settings);
  if (!accelerator) {
    const SteadyClock clock;
    const Time begin = clock.now();
    accelerator =
        accelerators_->build(assignment.scene_id, *assignment.scene, assignment.settings, threads_);
    build_seconds_ = to_seconds(clock.now() - begin);
  }
  return make_path_tracer(std::move(accelerator), assignment.scene->camera,
                          picture_of(assignment.settings));
}

void ThreadTeam::prepare(const LeaseWork& assignment) {
  if (tracer_ && scene_ == assignment.scene_id && same_tracer(settings_, assignment.settings)) {
    return;
  }
  if (!assignment.scene) throw std::logic_error("a lease without its scene");
  preparing_ = true;
  tracer_.reset();  // dropped before the next one is built: two may not fit into memory
  tracer_ = tracer_for(assignment);
  scene_ = assignment.scene_id;
  settings_ = assignment.settings;
  preparing_ = false;
}

LeaseResult ThreadTeam::trace(const LeaseWork& assignment, const std::atomic<bool>& stop) {
  LeaseResult finished;
  finished.job = assignment.job;
  finished.epoch = assignment.epoch;
  finished.grid = assignment.cells.grid;
  const auto fail = [&](const char* what) {
    tracer_.reset();  // first, because there may be no memory for the message
    preparing_ = false;
    finished.cells.reset();
    finished.failure = printable(what, longest_reason);
  };
  try {
    prepare(assignment);
    finished.cells = std::make_shared<const TracedCells>(
        trace_cells(*tracer_, assignment.cells, threads_, traced_, stop, assignment.longest));
    finished.build_seconds = build_seconds_;
    finished.accelerator_bytes = tracer_->accelerator()->bytes();
    finished.isa = tracer_->isa();
  } catch (const std::bad_alloc&) {
    fail("not enough memory");
  } catch (const std::exception& error) {
    fail(error.what());
  }
  return finished;
}

}  // namespace parray::worker
