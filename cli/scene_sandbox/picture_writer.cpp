#include "cli/scene_sandbox/picture_writer.h"

#include <algorithm>
#include <memory>
#include <nlohmann/json.hpp>
#include <span>
#include <utility>

#include "cli/commands/drawing.h"
#include "cli/output/error_map.h"
#include "cli/output/extra_channels.h"
#include "cli/output/picture/image_file.h"
#include "cli/output/picture/thumbnail.h"
#include "cli/output/write_outputs.h"
#include "common/base/cpu_count.h"
#include "common/image/picture_bytes.h"
#include "common/scene/scene_bytes.h"
#include "common/scene/settings.h"
#include "proto/settings_json.h"

namespace parray::scene_sandbox {
namespace {

using nlohmann::json;

Picture read_picture(const PictureRequest& request) {
  Picture picture;
  picture.report = json::parse(kept_bytes("report"));
  PictureParts parts =
      picture_from_bytes(static_cast<std::uint32_t>(request.width),
                         static_cast<std::uint32_t>(request.height), kept_bytes("pixels"));
  picture.image = std::move(parts.image);
  picture.statistics = std::move(parts.statistics);
  return picture;
}

/// Denoises the picture, and prepares what is drawn on it, as `parray fetch` does.
void use_scene(const PictureRequest& request, Picture& picture, OutputPaths& outputs) {
  constexpr int most_threads = 2;  // the server has other work
  const auto settings = settings_from_json(json::parse(kept_bytes("settings")));
  const auto scene = std::make_shared<const Scene>(scene_from_bytes(kept_bytes("scene")));
  outputs.image = request.wanted;
  outputs.denoise = request.denoise;
  if (request.draw) add_drawing(outputs, kept_bytes("drawing"), scene, settings);
  if (!outputs.legends.empty()) picture.report["legends"] = json::parse(outputs.legends);
  ExtraChannels extra =
      extra_channels(outputs, settings, scene, std::min(usable_cpus(), most_threads));
  extra.denoise = request.denoise;
  add_channels(picture, extra);
}

void keep_floats(const std::string& file, std::span<const float> values) {
  keep_bytes(file, {reinterpret_cast<const char*>(values.data()), values.size_bytes()});
}

}  // namespace

void write_picture_file(const PictureRequest& request, const ChildResources& resources) {
  constexpr std::uint64_t most_of_head = std::uint64_t{1} << 20;
  constexpr std::uint64_t most_of_pixel = 128;
  const std::string& wanted = request.wanted;
  confine(resources, most_of_head + most_of_pixel * request.width * request.height);
  Picture picture = read_picture(request);
  OutputPaths outputs;
  if (request.denoise || request.draw) use_scene(request, picture, outputs);
  if (request.thumbnail_width > 0) {
    const auto width = static_cast<std::uint32_t>(request.thumbnail_width);
    write_image(wanted, thumbnail(picture.image, width), {{"Software", "ParRay " PARRAY_VERSION}});
  } else if (wanted == "pixels.f32") {
    keep_floats(wanted, picture.image.rgb);
  } else if (wanted == "error.png") {
    write_error_map(wanted, picture);
  } else if (wanted == "error.f32") {
    keep_floats(wanted, half_widths_of(picture.statistics, request.width * request.height));
  } else if (picture.report.value("partial", false)) {
    write_image(wanted, picture.image,
                {{"Software", "ParRay " PARRAY_VERSION}, {"parray:partial", std::uint64_t{1}}});
  } else {
    if (can_hold_channels(wanted)) add_sample_counts(picture);
    write_picture(wanted, picture, outputs);
  }
}

}  // namespace parray::scene_sandbox
