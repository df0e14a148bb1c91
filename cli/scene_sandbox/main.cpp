// parray-http-child: reads uploaded scenes and writes picture files for the coordinator's HTTP
// service. Memory and processor time are limited. The process can open files only in the parent of
// its current directory (confinement.h). Only the coordinator starts this program.
#include <algorithm>
#include <functional>
#include <iostream>
#include <memory>
#include <nlohmann/json.hpp>
#include <span>
#include <string>
#include <utility>

#include "cli/commands/drawing.h"
#include "cli/commands/options.h"
#include "cli/output/error_map.h"
#include "cli/output/extra_channels.h"
#include "cli/output/picture/image_file.h"
#include "cli/output/picture/thumbnail.h"
#include "cli/output/write_outputs.h"
#include "cli/scene_sandbox/confinement.h"
#include "cli/scene_sandbox/upload_jobs.h"
#include "common/base/cpu_count.h"
#include "common/base/text.h"
#include "common/image/picture_bytes.h"
#include "common/process/run_main.h"
#include "common/scene/scene_bytes.h"
#include "proto/settings_json.h"

namespace {

using namespace parray::scene_sandbox;
using nlohmann::json;

// The name is parray, because users read the messages as those of the command line.
constexpr Program as_parray = {"parray", "Read scenes and write pictures for the HTTP service",
                               PARRAY_VERSION};

/// A file of a picture to write. All files are in the current directory.
struct PictureRequest {
  /// Name of the new file. pixels.f32: the floats of the picture. error.f32: the half-widths.
  /// error.png: the map of the error. Any other name: the picture, in the format of the extension.
  /// With a thumbnail_width, the file is a picture, whatever its name.
  std::string wanted;
  std::size_t width = 0;  ///< of the whole picture, in pixels
  std::size_t height = 0;
  std::size_t thumbnail_width = 0;  ///< width in pixels of a smaller picture; 0: the whole picture
  /// Denoises the picture first. The file `pixels` must then contain the replicates, too.
  bool denoise = false;
  bool draw = false;  ///< draws what the file `drawing` says (cli/commands/drawing.h)
  // denoise and draw need two more files: `scene`, the bytes of the scene, and `settings`, JSON.
};

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

/// Confines this process. Reads the files `pixels` (common/image/picture_bytes.h) and `report`, and
/// writes the file `wanted`. Throws RunError if the process cannot be confined, or a file cannot be
/// read or written.
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

struct Arguments {
  ChildResources resources;
  UploadRequest upload;
  UploadRequest planned;
  PictureRequest picture;
  std::size_t first = 0;
  std::size_t threads = 0;
  std::string foreign;
};

/// Prints on stderr, in one line, the forbidden actions that succeed. Prints nothing if all are
/// refused.
void confinement(const Arguments& a) {
  constexpr std::uint64_t small = 1000;
  confine(a.resources, small);
  const std::string text = joined(ways_out(enclosure_of(small), a.foreign), ", ");
  if (!text.empty()) std::cerr << text << '\n';
}

/// Makes `work` what the program does if the command line names `command`.
void does(Command& command, std::function<void()> work) {
  command.runs([work = std::move(work)] {
    work();
    return 0;
  });
}

Command upload_command(CommandLine& line, const std::string& name, const std::string& about,
                       UploadRequest& upload) {
  Command command = line.command(name, about);
  add_scene(command, upload.scene);
  add_upload_options(command, upload);
  return command;
}

Command picture_command(CommandLine& line, PictureRequest& picture) {
  Command command = line.command("picture", "Write a picture file");
  command.option("FILE", picture.wanted, "").required();
  command.number("WIDTH", picture.width, 1, std::size_t{1} << 32, "").required();
  command.number("HEIGHT", picture.height, 1, std::size_t{1} << 32, "").required();
  command.number("--thumbnail-width", picture.thumbnail_width, 1, 1024, "Write a smaller copy");
  command.flag("--denoise", picture.denoise, "Denoise the picture first");
  command.flag("--draw", picture.draw, "Draw labels and outlines");
  return command;
}

}  // namespace

int main(int argc, char** argv) {
  Arguments a;
  return run_main(as_parray, argc, argv, [&](CommandLine& line) -> Action {
    line.number("--memory", a.resources.memory, 0, std::size_t{1} << 50, "Bytes").required();
    line.number("--seconds", a.resources.seconds, 1, 1000000, "Processor time").required();
    line.number("--first", a.first, 0, std::size_t{1} << 32, "Place of the first frame");
    line.number("--threads", a.threads, 0, std::size_t{1} << 32, "Threads of the farm");
    Command submit = upload_command(line, "submit", "Read a scene", a.upload);
    does(submit, [&] { write_upload_jobs(a.upload, a.first, a.resources); });
    Command plan = upload_command(line, "plan", "Forecast a scene", a.planned);
    does(plan, [&] { write_forecast(a.planned, a.threads, a.resources); });
    Command picture = picture_command(line, a.picture);
    does(picture, [&] { write_picture_file(a.picture, a.resources); });
    Command attempt = line.command("confinement", "Try forbidden actions");
    attempt.option("FILE", a.foreign, "File that the process must not be able to read").required();
    does(attempt, [&] { confinement(a); });
    return [&line] { return line.chosen() ? line.chosen()() : 2; };
  });
}
