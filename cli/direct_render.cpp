#include "cli/direct_render.h"

#include <ctime>
#include <limits>
#include <utility>

#include "proto/clock.h"
#include "worker/team.h"

namespace parray {
namespace {

double cpu_now() {
  timespec now{};
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

/// One picture on its way; passes as Job::next_pass() has them.
class Rendering {
 public:
  Rendering(const Kernel& kernel, const Scene& scene, const RenderSettings& settings, int threads,
            const std::atomic<bool>& stop)
      : kernel_(kernel), settings_(settings), threads_(threads), stop_(stop), picture_(settings) {
    picture_.largest_radiance = largest_radiance(scene);
  }

  std::optional<DirectRender> run(const std::function<void(const DirectRender&)>& after_pass) {
    const double cpu_began = cpu_now();
    const auto take_time = [&] {
      picture_.seconds = to_seconds(clock_.now() - began_);
      picture_.cpu_seconds = cpu_now() - cpu_began;
    };
    began_ = clock_.now();
    if (settings_.in_passes()) {
      while (!stop_ && next_pass()) {
        trace_pass();
        take_time();
        if (after_pass && !stop_) after_pass(picture_);
      }
    } else {
      trace_pass();
    }
    if (stop_) return std::nullopt;
    take_time();
    return std::move(picture_);
  }

 private:
  /// What the time left allows, at the speed of the pass before.
  [[nodiscard]] std::uint64_t affordable(Time now) const {
    if (settings_.time_limit == 0 || picture_.passes.empty()) {
      return std::numeric_limits<std::uint64_t>::max();
    }
    const double left = settings_.time_limit - to_seconds(now - began_);
    const double took = to_seconds(now - pass_began_);
    if (left <= 0 || took <= 0) return 0;
    const std::uint64_t traced = picture_.framebuffer.counts().samples - samples_before_;
    return static_cast<std::uint64_t>(static_cast<double>(traced) / took * left);
  }

  bool next_pass() {
    const Time now = clock_.now();
    const auto pass = static_cast<std::uint32_t>(picture_.passes.size());
    const PassSize next = next_pass_size(picture_.state(), settings_, pass, affordable(now));
    picture_.stopped_by = next.stop;
    if (next.samples == 0) return false;
    samples_before_ = picture_.framebuffer.counts().samples;
    pass_began_ = now;
    picture_.framebuffer.begin_pass(
        counts_after_pass(picture_.state(), settings_, pass, next.samples));
    if (picture_.framebuffer.pass_rect().units() == 0) return false;  // no pixel may have more
    picture_.passes.push_back(next.samples);
    return true;
  }

  void trace_pass() {
    const WorkRect rect = picture_.framebuffer.pass_rect();
    std::atomic<std::uint64_t> traced = 0;
    const RowBlock block = trace_rect(kernel_, settings_, rect, threads_, traced, stop_,
                                      picture_.framebuffer.samples_of(rect));
    if (!stop_) picture_.framebuffer.merge(block);
  }

  const Kernel& kernel_;
  const RenderSettings& settings_;
  const int threads_;
  const std::atomic<bool>& stop_;
  const SteadyClock clock_;
  DirectRender picture_;
  Time began_{};
  Time pass_began_{};
  std::uint64_t samples_before_ = 0;
};

}  // namespace

BuiltKernel build_kernel(const Scene& scene, const RenderSettings& settings, int threads) {
  const SteadyClock clock;
  const Time began = clock.now();
  KernelOptions options;
  options.build_threads = threads;
  BuiltKernel built{make_kernel(scene, settings, options), 0};
  built.build_seconds = to_seconds(clock.now() - began);
  return built;
}

double DirectRender::samples_per_pixel() const {
  return static_cast<double>(framebuffer.counts().samples) /
         static_cast<double>(framebuffer.pixels().size());
}

std::optional<DirectRender> render_directly(
    const Kernel& kernel, const Scene& scene, const RenderSettings& settings, int threads,
    const std::atomic<bool>& stop, const std::function<void(const DirectRender&)>& after_pass) {
  return Rendering(kernel, scene, settings, threads, stop).run(after_pass);
}

StopWatch::StopWatch(std::function<bool()> asked)
    : thread_([this, asked = std::move(asked)](const std::stop_token& end) {
        while (!end.stop_requested()) {
          if (asked()) {
            stop_ = true;
            return;
          }
          std::this_thread::sleep_for(milliseconds(20));
        }
      }) {}

}  // namespace parray
