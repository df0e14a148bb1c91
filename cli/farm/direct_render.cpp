#include "cli/farm/direct_render.h"

#include <algorithm>
#include <ctime>
#include <utility>

#include "common/adaptive/pass_controller.h"
#include "common/scene/largest_radiance.h"
#include "common/scene/settings.h"
#include "coordinator/leases/result_collector.h"
#include "proto/clock.h"
#include "worker/cell_tracer.h"

namespace parray::farm {
namespace {

double cpu_now() {
  timespec now{};
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

/// Largest size of the records that are traced before they are added to the picture.
constexpr std::size_t most_record_bytes = std::size_t{1} << 26;

/// The rendering of one picture.
class Rendering {
 public:
  Rendering(const PathTracer& tracer, const Scene& scene, const RenderSettings& settings,
            int threads, const std::atomic<bool>& stop)
      : tracer_(tracer),
        settings_(settings),
        threads_(threads),
        stop_(stop),
        picture_(settings, largest_radiance(scene)),
        passes_(settings, picture_.largest_radiance) {}

  std::optional<DirectRender> run(const std::function<void(const DirectRender&)>& after_pass) {
    const double cpu_began = cpu_now();
    const Time began = clock_.now();
    Time pass_began = began;
    while (!stop_) {
      const Time now = clock_.now();
      const auto pass = next_pass({to_seconds(now - began), to_seconds(now - pass_began)});
      if (!pass) break;
      pass_began = now;
      trace(*pass);
      picture_.seconds = to_seconds(clock_.now() - began);
      picture_.cpu_seconds = cpu_now() - cpu_began;
      if (after_pass && settings_.in_passes() && !stop_) after_pass(picture_);
    }
    if (stop_) return std::nullopt;
    picture_.seconds = to_seconds(clock_.now() - began);
    picture_.cpu_seconds = cpu_now() - cpu_began;
    picture_.passes = passes_.begun();
    picture_.stopped_by = passes_.stopped_by();
    return std::move(picture_);
  }

 private:
  std::optional<Pass> next_pass(const PassTimes& times) {
    const double cpu_began = cpu_now();
    const Time began = clock_.now();
    auto pass = passes_.next(picture_.framebuffer, times);
    picture_.deciding_seconds += to_seconds(clock_.now() - began);
    picture_.deciding_cpu_seconds += cpu_now() - cpu_began;
    return pass;
  }

  void trace(const Pass& pass) {
    const auto plan = std::make_shared<const WorkPlan>(settings_, pass);
    ResultCollector collector(plan, picture_.framebuffer);
    const std::uint64_t most = std::max<std::uint64_t>(
        most_record_bytes / record_bytes(plan->grid()->shape().cell_pixels), 1);
    std::atomic<std::uint64_t> traced = 0;
    for (std::uint64_t begin = 0; begin < plan->cells(); begin += most) {
      const CellRange range{begin, std::min(begin + most, plan->cells())};
      const TracedCells cells = trace_cells(tracer_, plan->batch(range), threads_, traced, stop_);
      if (stop_) return;
      collector.take(0, cells);
    }
  }

  const PathTracer& tracer_;
  const RenderSettings& settings_;
  const int threads_;
  const std::atomic<bool>& stop_;
  const SteadyClock clock_;
  DirectRender picture_;
  PassController passes_;
};

}  // namespace

DirectRender::DirectRender(const RenderSettings& settings, double largest)
    : framebuffer(settings.width, settings.height), largest_radiance(largest) {}

double DirectRender::samples_per_pixel() const {
  return static_cast<double>(framebuffer.counts().samples) /
         static_cast<double>(framebuffer.pixels().size());
}

std::optional<DirectRender> render_directly(
    const PathTracer& tracer, const Scene& scene, const RenderSettings& settings, int threads,
    const std::atomic<bool>& stop, const std::function<void(const DirectRender&)>& after_pass) {
  return Rendering(tracer, scene, settings, threads, stop).run(after_pass);
}

StopPoller::StopPoller(std::function<bool()> asked)
    : thread_([this, asked = std::move(asked)](const std::stop_token& end) {
        while (!end.stop_requested()) {
          if (asked()) {
            stop_ = true;
            return;
          }
          std::this_thread::sleep_for(milliseconds(20));
        }
      }) {}

}  // namespace parray::farm
