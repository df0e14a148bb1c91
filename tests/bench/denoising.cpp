// What denoising a picture takes, by parts, beside a sample of it: processor time of one thread.
#include <atomic>
#include <cstdio>
#include <exception>
#include <filesystem>
#include <string>

#include "cli/farm/direct_render.h"
#include "cli/input/scene_file/scene_file.h"
#include "cli/output/denoise/denoise.h"
#include "common/adaptive/error_estimate.h"
#include "common/adaptive/replicates.h"
#include "common/scene/requirements.h"
#include "common/scene/settings.h"
#include "common/trace/tracer.h"
#include "tests/bench/bench.h"
#include "tests/support/rooms.h"

namespace parray {
namespace {

int run(int count, char** words) {
  const Scene scene = read_scene_file(std::filesystem::path(words[1])).scene;
  RenderSettings settings;
  settings.width = static_cast<std::uint32_t>(std::stoul(words[2]));
  settings.height = static_cast<std::uint32_t>(std::stoul(words[3]));
  settings.samples_per_pixel = static_cast<std::uint32_t>(std::stoul(words[4]));
  if (count > 5) settings.isa = isa_from(words[5]);
  settings = resolve_settings(requirements_of(scene), settings).settings;
  const auto tracer = make_path_tracer(scene, settings);
  const std::atomic<bool> never = false;
  const auto picture = render_directly(*tracer, scene, settings, 1, never);
  const Replicates replicates = replicates_of(picture->state());

  std::vector<double> features_seconds;
  std::vector<double> filter_seconds;
  Denoised denoised;
  constexpr int turns = 5;
  for (int turn = 0; turn < turns; ++turn) {
    const double began = bench::cpu_seconds();
    const Features features = trace_features(*tracer, *steady_tracer(*tracer, scene, settings),
                                             scene, settings, settings.samples_per_pixel, 1);
    const double traced = bench::cpu_seconds();
    denoised = denoise::denoise(replicates, features, 1, settings.isa);
    features_seconds.push_back(traced - began);
    filter_seconds.push_back(bench::cpu_seconds() - traced);
  }
  const double pixels = static_cast<double>(settings.width) * settings.height;
  const double microseconds = 1e6 / pixels;
  const double sample = picture->cpu_seconds * microseconds / settings.samples_per_pixel;
  const double features = bench::median(features_seconds) * microseconds;
  const double filter = bench::median(filter_seconds) * microseconds;
  std::printf(
      "{\"sample\": %.4f, \"features\": %.3f, \"filter\": %.3f, \"as_many_samples\": %.1f, "
      "\"raw\": %.6g, \"denoised\": %.6g, \"low\": %.6g, \"high\": %.6g}\n",
      sample, features, filter, (features + filter) / sample, estimate_error(picture->state()).rmse,
      denoised.rmse, denoised.low, denoised.high);
  return 0;
}

}  // namespace
}  // namespace parray

int main(int argc, char** argv) {
  parray::bench::warn_of_assertions();
  if (argc < 5 || argc > 6) {
    std::puts(
        "usage: bench_denoising SCENE.json WIDTH HEIGHT SAMPLES [ISA]\n"
        "prints microseconds of processor time a pixel: of a sample, of features, of the filter");
    return 2;
  }
  try {
    return parray::run(argc, argv);
  } catch (const std::exception& error) {
    std::fprintf(stderr, "%s\n", error.what());
    return 1;
  }
}
