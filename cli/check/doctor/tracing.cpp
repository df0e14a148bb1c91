#include "cli/check/doctor/tracing.h"

#include <algorithm>
#include <array>
#include <atomic>
#include <exception>
#include <sstream>

#include "cli/farm/direct_render.h"
#include "cli/output/text.h"
#include "common/base/error.h"
#include "common/image/image.h"
#include "common/scene/largest_radiance.h"
#include "common/scene/requirements.h"
#include "common/scene/settings.h"

namespace parray::doctor {

const std::string_view doctor_scene_text = R"({"version": 1,
"camera": {"look_from": [3, 2, 5], "look_at": [0, 0.5, 0], "up": [0, 1, 0], "vfov": 40,
           "aperture": 0.1, "focus_distance": 6},
"image": {"width": 48, "height": 32},
"render": {"samples_per_pixel": 16, "max_depth": 12, "seed": 1},
"sky": {"horizon": [1, 1, 1], "zenith": [0.5, 0.7, 1.0]},
"materials": {"ground": {"type": "diffuse", "albedo": [0.5, 0.5, 0.5]},
              "gold": {"type": "metal", "albedo": [0.8, 0.6, 0.2], "fuzz": 0.1},
              "glass": {"type": "dielectric", "ior": 1.5},
              "bubble": {"type": "dielectric", "ior": 0.6666666666666666}},
"spheres": [{"center": [0, -100, 0], "radius": 100, "material": "ground"},
            {"center": [-1.1, 0.5, 0], "radius": 0.5, "material": "gold"},
            {"center": [0, 0.5, 0], "radius": 0.5, "material": "glass"},
            {"center": [0, 0.5, 0], "radius": 0.4, "material": "bubble"},
            {"center": [1.1, 0.5, 0], "radius": 0.5, "material": "ground"},
            {"center": [0.4, 0.2, 1], "radius": 0.2, "material": "gold"},
            {"center": [-0.5, 0.2, 1.2], "radius": 0.2, "material": "glass"}]}
)";

namespace {

constexpr std::array accelerators{AcceleratorKind::linear, AcceleratorKind::bvh};

}  // namespace

TracerMaker tracers_of(Isa isa) {
  return [isa](const Scene& scene, RenderSettings settings) {
    settings.isa = isa;
    return make_path_tracer(scene, settings);
  };
}

SceneFile doctor_scene() {
  std::istringstream text{std::string(doctor_scene_text)};
  return read_scene(text, "the doctor's scene");
}

CheckResult check_picture(const TracerMaker& make, std::string_view expected) {
  std::string wrong;
  for (const AcceleratorKind accelerator : accelerators) {
    const auto with_accelerator = [&](const Scene& scene, RenderSettings settings) {
      settings.accelerator = accelerator;
      return make(scene, settings);
    };
    const std::string found = trace_fingerprint(with_accelerator);
    if (found != expected) {
      wrong += (wrong.empty() ? "" : ", ") + std::string(name_of(accelerator)) + " traces " +
               found.substr(0, 16);
    }
  }
  if (wrong.empty()) {
    return passed("the built-in picture has the known bits in f32, mixed, f64, linear and bvh");
  }
  return failed("the built-in picture does not have the SHA-256 " +
                    std::string(expected.substr(0, 16)) + ": " + wrong,
                wrong_bits);
}

std::string doctor_image_sha256(const TracerMaker& make, int threads) {
  const SceneFile file = doctor_scene();
  const RenderSettings settings =
      resolve_settings(requirements_of(file.scene), file.settings).settings;
  const std::atomic<bool> stop = false;
  const auto picture =
      render_directly(*make(file.scene, settings), file.scene, settings, threads, stop);
  return image_sha256(resolve_image(picture->framebuffer, picture->largest_radiance));
}

CheckResult check_threads(const TracerMaker& make, int threads) {
  const std::string alone = doctor_image_sha256(make, 1);
  const std::array others{doctor_image_sha256(make, threads), doctor_image_sha256(make, 1),
                          doctor_image_sha256(make, threads)};
  const auto count = counted(static_cast<std::uint64_t>(threads), "thread");
  if (std::ranges::all_of(others, [&](const std::string& other) { return other == alone; })) {
    return passed("1 thread and " + count + " make the same picture, twice: SHA-256 " +
                  alone.substr(0, 16));
  }
  return failed("pictures of 1 thread and " + count + " differ",
                "test the machine's memory, and undo any overclocking");
}

CheckResult check_repetition(const std::function<std::string()>& picture, int times, int threads) {
  const std::string expected = picture();
  std::uint64_t different = 0;
  std::atomic<bool> thrown = false;
#pragma omp parallel for num_threads(threads) schedule(static) reduction(+ : different)
  for (int i = 0; i < times * threads; ++i) {
    try {
      different += picture() == expected ? 0 : 1;
    } catch (const std::exception&) {  // an exception must not leave the team
      thrown = true;
    }
  }
  if (thrown) throw RunError("tracing the built-in picture failed: free some memory and try again");
  const auto total = static_cast<std::uint64_t>(times) * static_cast<std::uint64_t>(threads);
  const std::string text = counted(total, "time") + " on " +
                           counted(static_cast<std::uint64_t>(threads), "thread") + " at once";
  return different == 0 ? passed("the same picture " + text)
                        : failed(std::to_string(different) +
                                     " different pictures; the same one was traced " + text,
                                 "test the machine's memory, and undo any overclocking");
}

}  // namespace parray::doctor
