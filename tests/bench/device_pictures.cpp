#include <array>
#include <cstdio>
#include <span>

#include "common/scene/setting_choices.h"
#include "common/trace/device/device_fingerprint.h"
#include "common/trace/tracer.h"
#include "tests/bench/device_checks.h"
#include "tests/bench/on_processors.h"
#include "tests/support/scene_files.h"

namespace parray::bench {
namespace {

using test::DevicePictureSums;
using test::ReferenceSums;

/// Scenes with more shapes are not traced by linear search.
constexpr std::size_t most_linear = 20'000;

ReferenceSums cpu_sums(const Scene& scene, const RenderSettings& settings) {
  const auto tracer = make_path_tracer(scene, settings);
  ReferenceSums sums{std::vector<PixelSums>(std::size_t{settings.width} * settings.height), {}};
  std::vector<TraceCounts> counts(settings.height);
  on_processors(settings.height, [&](std::size_t y) {
    tracer->trace({static_cast<std::uint32_t>(y), 0, settings.width},
                  {0, settings.samples_per_pixel},
                  std::span(sums.pixels).subspan(y * settings.width, settings.width), counts[y]);
  });
  for (const TraceCounts& row : counts) sums.counts += row;
  return sums;
}

std::string unequal(const std::string& what, std::uint64_t found, std::uint64_t expected) {
  return found == expected
             ? ""
             : what + " is " + std::to_string(found) + ", not " + std::to_string(expected);
}

std::string difference(const PixelSums& found, const PixelSums& expected) {
  for (std::size_t channel = 0; channel < 3; ++channel) {
    const std::string of = " of channel " + std::to_string(channel);
    for (const std::string& text :
         {unequal("the sum" + of, found.sum[channel], expected.sum[channel]),
          unequal("the sum of squares" + of, found.sum_of_squares[channel],
                  expected.sum_of_squares[channel]),
          unequal("the sum of odd samples" + of, found.odd[channel], expected.odd[channel])}) {
      if (!text.empty()) return text;
    }
  }
  return "";
}

std::string difference(const TraceCounts& found, const TraceCounts& expected) {
  for (const std::string& text :
       {unequal("the number of rays", found.rays, expected.rays),
        unequal("the number of samples", found.samples, expected.samples),
        unequal("the number of non-finite samples", found.nonfinite, expected.nonfinite),
        unequal("the lost light", found.lost, expected.lost)}) {
    if (!text.empty()) return text;
  }
  return "";
}

/// Describes the first difference of two pictures; empty: they are equal.
std::string difference(const ReferenceSums& found, const ReferenceSums& expected,
                       std::uint32_t width) {
  std::size_t differ = 0;
  std::string first;
  for (std::size_t i = 0; i < expected.pixels.size(); ++i) {
    const std::string text = difference(found.pixels[i], expected.pixels[i]);
    if (!text.empty() && differ++ == 0) {
      first =
          "pixel (" + std::to_string(i % width) + ", " + std::to_string(i / width) + "): " + text;
    }
  }
  if (differ > 0) {
    return first + " (" + std::to_string(differ) + " of " + std::to_string(expected.pixels.size()) +
           " pixels differ)";
  }
  return difference(found.counts, expected.counts);
}

std::string words(const RenderSettings& settings) {
  return std::string(name_of(settings.precision)) + ", " +
         std::string(name_of(settings.accelerator)) + ", " + std::string(name_of(settings.sampler));
}

/// Counts pictures that a device has traced.
class PictureCheck {
 public:
  PictureCheck(const test::CudaLauncher& device, Verdict& verdict)
      : device_(device), verdict_(verdict) {}

  /// Traces a picture on the device and compares it. Returns the device's sums.
  ReferenceSums trace(const std::string& name, const Scene& scene, const RenderSettings& settings,
                      const ReferenceSums& expected) {
    DevicePictureSums found = test::device_sums(scene, settings, device_);
    const std::string text = difference(found.sums, expected, settings.width);
    ++pictures_;
    handed_back_ += found.handed_back;
    if (!text.empty()) {
      ++different_;
      verdict_.wrong("picture " + name + " (" + words(settings) + "), " + text);
    }
    return std::move(found.sums);
  }

  [[nodiscard]] Json figures() const {
    return {
        {"pictures", pictures_}, {"different", different_}, {"items_handed_back", handed_back_}};
  }

 private:
  const test::CudaLauncher& device_;
  Verdict& verdict_;
  std::uint64_t pictures_ = 0;
  std::uint64_t different_ = 0;
  std::uint64_t handed_back_ = 0;
};

void check_scene(const test::NamedScene& named, PictureCheck& check) {
  const std::size_t shapes = named.scene.spheres.size() + named.scene.capsules.size();
  RenderSettings settings = named.settings;
  for (const Precision precision : {Precision::f32, Precision::mixed, Precision::f64}) {
    for (const Sampler sampler : {Sampler::sobol, Sampler::independent}) {
      settings.precision = precision;
      settings.sampler = sampler;
      settings.accelerator = AcceleratorKind::bvh;
      const ReferenceSums expected = cpu_sums(named.scene, settings);
      check.trace(named.name, named.scene, settings, expected);
      if (shapes > most_linear) continue;
      settings.accelerator = AcceleratorKind::linear;
      check.trace(named.name, named.scene, settings, expected);
    }
  }
}

}  // namespace

void Verdict::wrong(const std::string& what) {
  std::printf("WRONG: %s\n", what.c_str());
  found_.push_back(what);
}

Json check_fingerprint(const test::CudaLauncher& device, Verdict& verdict) {
  PictureCheck check(device, verdict);
  int number = 0;
  const std::string on_device =
      device_fingerprint([&](const Scene& scene, const RenderSettings& settings,
                             std::span<PixelSums> pixels, TraceCounts& counts) {
        const std::string name = "of the fingerprint " + std::to_string(number++ / 3 + 1);
        const ReferenceSums sums = check.trace(name, scene, settings, cpu_sums(scene, settings));
        std::copy(sums.pixels.begin(), sums.pixels.end(), pixels.begin());
        counts += sums.counts;
      });
  const std::string on_cpu =
      device_fingerprint([](const Scene& scene, const RenderSettings& settings,
                            std::span<PixelSums> pixels, TraceCounts& counts) {
        const ReferenceSums sums = cpu_sums(scene, settings);
        std::copy(sums.pixels.begin(), sums.pixels.end(), pixels.begin());
        counts += sums.counts;
      });
  const std::string pinned(pinned_device_fingerprint);
  if (on_device != on_cpu) verdict.wrong("fingerprint " + on_device + ", not the CPU's " + on_cpu);
  if (!pinned.empty() && on_device != pinned) {
    verdict.wrong("fingerprint " + on_device + ", not the pinned " + pinned);
  }
  std::printf("fingerprint %s%s\n", on_device.c_str(), on_device == pinned ? ", as pinned" : "");
  Json figures = {{"device", on_device}, {"cpu", on_cpu}, {"pinned", pinned}};
  figures.update(check.figures());
  return figures;
}

Json check_pictures(const std::filesystem::path& scenes, const PictureSize& size,
                    const test::CudaLauncher& device, Verdict& verdict) {
  PictureCheck check(device, verdict);
  const auto files = test::scene_files(scenes, size.width, size.height, size.samples);
  for (const test::NamedScene& named : files) check_scene(named, check);
  Json figures = check.figures();
  figures["scenes"] = files.size();
  std::printf("pictures: %s of %zu scenes, %s different, %s items handed back to the CPU\n",
              figures["pictures"].dump().c_str(), files.size(), figures["different"].dump().c_str(),
              figures["items_handed_back"].dump().c_str());
  return figures;
}

}  // namespace parray::bench
