// parray-mpi with a faulty rank 1, for tests. The linker replaces make_path_tracer() by this code.
//
// PARRAY_LIARS names an empty folder. By files in it, three ranks tell each other their progress.
// Each has a third of the picture (--schedule static --threads 1). Rank 1 returns wrong sums for
// every cell. Rank 2 delays its third until rank 1 has copied some of it, so that results are
// compared. Rank 0 copies nothing before that. The main thread, which traces the built-in picture
// and decides disputes, is always right. Without PARRAY_LIARS all ranks are right.
#include <unistd.h>

#include <chrono>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <string>
#include <thread>

#include "cli/mpi/mpi_world.h"
#include "common/scene/settings.h"
#include "common/trace/integrator/path_tracer.h"
#include "tests/support/rooms.h"

namespace parray {
namespace {

namespace fs = std::filesystem;

using std::chrono::milliseconds;

constexpr std::uint32_t ranks = 3;
constexpr std::uint32_t faulty = 1;
constexpr std::uint32_t late = 2;
/// Cells of a third of the picture: 100 x 75 pixels of 100 samples, 20 pixels in a cell.
constexpr int third = 125;
/// More cells than the first two copies have. Each has a sixth of the missing cells, and the first
/// may belong to the faulty rank's own third.
constexpr int copied = 90;

class ScriptedTracer final : public PathTracer {
 public:
  ScriptedTracer(std::unique_ptr<PathTracer> honest, fs::path folder)
      : PathTracer(honest->accelerator()),
        honest_(std::move(honest)),
        folder_(std::move(folder)),
        rank_(rank_in_environment()) {}

  void trace_run(const PixelRun& run, const RunSamples& samples, std::span<PixelSums> sums,
                 TraceCounts& counts) const override {
    follow_script();
    ++cells_;
    honest_->trace_run(run, samples, sums, counts);
    if (rank_ == late && cells_ == third) say("traced");
    if (rank_ == faulty) sums[0].sum[0] += sums[0].sum[0] > 0 ? ~std::uint64_t{0} : 1;
  }
  void first_hits(const PixelRun& run, const SampleRange& samples,
                  std::span<FirstHit> hits) const override {
    honest_->first_hits(run, samples, hits);
  }
  void add_sky_samples(const PixelRun& run, const RunSamples& samples,
                       std::span<SkySamples> sky) const override {
    honest_->add_sky_samples(run, samples, sky);
  }

 private:
  /// Waits as the rank must before its next cell. The first cells of a rank are its third, all
  /// others are copies.
  void follow_script() const {
    if (cells_ == 0) {
      say("begun-" + std::to_string(rank_));
      for (std::uint32_t rank = 0; rank < ranks; ++rank) wait_for("begun-" + std::to_string(rank));
    }
    if (rank_ == late && cells_ == 0) {
      wait_for_results("copied");
    } else if (rank_ == faulty && cells_ == third + copied) {
      say("copied");
      wait_for_results("traced");
    } else if (rank_ == 0 && cells_ == third) {
      wait_for_results("traced");
    }
  }

  void say(const std::string& what) const { std::ofstream(folder_ / what).put('\n'); }

  void wait_for(const std::string& what) const {
    for (milliseconds waited{}; !fs::exists(folder_ / what) && waited < milliseconds(60'000);
         waited += milliseconds(2)) {
      std::this_thread::sleep_for(milliseconds(2));
    }
  }

  /// Waits for the file `what`, and then until its rank has handed in the cells that it traced.
  void wait_for_results(const std::string& what) const {
    wait_for(what);
    std::this_thread::sleep_for(milliseconds(300));
  }

  const std::unique_ptr<PathTracer> honest_;
  const fs::path folder_;
  const std::uint32_t rank_;
  // Teams have one thread.
  mutable int cells_ = 0;  ///< traced
};

}  // namespace

#define PARRAY_TRACER_SYMBOL                                 \
  "_ZN6parray5trace16make_path_tracerESt10shared_ptrIKNS0_1" \
  "1AcceleratorEERKNS_5scene6CameraERKNS5_15PictureSettingsEb"

std::unique_ptr<PathTracer> honest_tracer(std::shared_ptr<const Accelerator> accelerator,
                                          const Camera& camera, const PictureSettings& picture,
                                          bool general) asm("__real_" PARRAY_TRACER_SYMBOL);
std::unique_ptr<PathTracer> scripted_tracer(std::shared_ptr<const Accelerator> accelerator,
                                            const Camera& camera, const PictureSettings& picture,
                                            bool general) asm("__wrap_" PARRAY_TRACER_SYMBOL);

std::unique_ptr<PathTracer> scripted_tracer(std::shared_ptr<const Accelerator> accelerator,
                                            const Camera& camera, const PictureSettings& picture,
                                            bool general) {
  auto honest = honest_tracer(std::move(accelerator), camera, picture, general);
  // NOLINTNEXTLINE(concurrency-mt-unsafe): nothing here changes the environment
  const char* const folder = std::getenv("PARRAY_LIARS");
  const bool in_team = gettid() != getpid();
  if (folder == nullptr || !in_team) return honest;
  return std::make_unique<ScriptedTracer>(std::move(honest), folder);
}

}  // namespace parray
