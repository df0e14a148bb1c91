#include "tests/fuzz/target.h"

#include <algorithm>
#include <array>

#include "common/base/printable.h"
#include "common/scene/largest_radiance.h"
#include "common/scene/requirements.h"
#include "common/scene/scene_bytes.h"
#include "common/scene/settings.h"
#include "coordinator/jobs/job_picture.h"
#include "tests/support/rooms.h"

namespace parray::fuzz {

std::span<const Target* const> targets() {
  static constexpr std::array all{
      &scene_target,  &particles_target, &messages_target,  &bulk_target,
      &state_target,  &picture_target,   &selection_target, &keys_target,
#ifdef PARRAY_FUZZ_HTTP
      &chunks_target,
#endif
  };
  return all;
}

const Target& target_named(std::string_view name) {
  const auto found = std::ranges::find(targets(), name, &Target::name);
  if (found == targets().end()) {
    throw std::invalid_argument("no fuzz target '" + std::string(name) + "'");
  }
  return **found;
}

void promise(bool kept, const std::string& what) {
  if (!kept) throw Violation(what);
}

void promise_one_line(std::string_view message) {
  constexpr std::size_t most = 3000;
  promise(!message.empty() && message.size() < most, "a message that is empty or endless");
  promise(printable(message, most) == message, "a message that is not one printable line");
}

void promise_usable(const Scene& scene, const RenderSettings& settings) {
  const std::string bytes = scene_to_bytes(scene);
  promise(scene_from_bytes(bytes) == scene, "a scene reads back from its bytes as itself");
  promise(scene_identity(bytes) == scene_identity(scene), "one identity");
  check_settings(resolve_settings(requirements_of(scene), settings).settings);
  promise(largest_radiance(scene) >= 0, "a largest radiance");
}

void promise_startable(const RenderSettings& settings, const std::vector<std::uint64_t>& begun,
                       std::uint32_t tile) {
  constexpr std::uint64_t most_pixels = 4096;
  constexpr std::uint64_t most_samples = std::uint64_t{1} << 24;
  const std::uint64_t pixels = std::uint64_t{settings.width} * settings.height;
  if (pixels > most_pixels || pixels * settings.samples_per_pixel > most_samples) return;
  JobPicture picture(settings, SceneFacts(Scene()), begun, tile);
  promise(picture.begin_pass(), "a pass to begin with");
  promise(picture.plan()->cells() > 0, "cells to trace");
}

char take_letter(std::string_view& input) {
  if (input.empty()) return 0;
  const char letter = input.front();
  input.remove_prefix(1);
  return letter;
}

}  // namespace parray::fuzz
