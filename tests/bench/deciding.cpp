// What deciding on the passes of a picture takes, beside tracing them: seconds of processor, and
// by the clock on the wall.
#include <atomic>
#include <cstdio>
#include <exception>
#include <filesystem>
#include <string>

#include "cli/farm/direct_render.h"
#include "cli/input/scene_file/scene_file.h"
#include "common/adaptive/error_estimate.h"
#include "common/scene/requirements.h"
#include "common/scene/settings.h"
#include "common/trace/tracer.h"
#include "tests/bench/bench.h"
#include "tests/support/rooms.h"

namespace parray {
namespace {

void print(const DirectRender& picture) {
  const double began = bench::cpu_seconds();
  const ErrorEstimate error = estimate_error(picture.state());
  const double stating = bench::cpu_seconds() - began;
  std::printf(
      "{\"passes\": %zu, \"samples_per_pixel\": %.2f, \"seconds\": %.4f, \"cpu_seconds\": %.4f, "
      "\"deciding\": %.5f, \"deciding_cpu\": %.5f, \"stating_cpu\": %.5f, \"high\": %.6g, "
      "\"half_width_p99\": %.6g}\n",
      picture.passes.size(), picture.samples_per_pixel(), picture.seconds, picture.cpu_seconds,
      picture.deciding_seconds, picture.deciding_cpu_seconds, stating, error.high,
      error.half_width_p99);
}

int run(char** words) {
  const Scene scene = read_scene_file(std::filesystem::path(words[1])).scene;
  RenderSettings settings;
  settings.width = static_cast<std::uint32_t>(std::stoul(words[2]));
  settings.height = static_cast<std::uint32_t>(std::stoul(words[3]));
  settings.samples_per_pixel = 1 << 20;
  settings.adaptive = true;
  const double target = std::stod(words[6]);
  (std::string(words[5]) == "error" ? settings.target_error : settings.target_half_width) = target;
  settings = resolve_settings(requirements_of(scene), settings).settings;
  const std::atomic<bool> never = false;
  print(*render_directly(*make_path_tracer(scene, settings), scene, settings, std::stoi(words[4]),
                         never));
  return 0;
}

}  // namespace
}  // namespace parray

int main(int argc, char** argv) {
  parray::bench::warn_of_assertions();
  if (argc != 7) {
    std::puts("usage: bench_deciding SCENE.json WIDTH HEIGHT THREADS error|half-width TARGET");
    return 2;
  }
  try {
    return parray::run(argv);
  } catch (const std::exception& error) {
    std::fprintf(stderr, "%s\n", error.what());
    return 1;
  }
}
