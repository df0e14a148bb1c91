#include <algorithm>
#include <cstdint>
#include <filesystem>
#include <iostream>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "cli/commands/commands.h"
#include "cli/commands/options.h"
#include "cli/commands/prepare.h"
#include "cli/commands/rendering.h"
#include "cli/commands/time_reserve.h"
#include "cli/farm/embedded.h"
#include "cli/input/formats/format_table.h"
#include "cli/input/particles/packed_file.h"
#include "cli/input/view/view.h"
#include "cli/measure/plan/denoising_worth.h"
#include "cli/output/extra_channels.h"
#include "cli/output/picture/image_file.h"
#include "cli/output/picture/partial_file.h"
#include "cli/output/postprocess/postprocessing.h"
#include "cli/output/text.h"
#include "common/base/cpu_count.h"
#include "common/base/error.h"
#include "common/base/json_text.h"
#include "common/base/printable.h"
#include "common/base/text.h"
#include "common/process/stop_signal.h"
#include "common/scene/limits.h"
#include "common/scene/scene_bytes.h"
#include "common/scene/settings.h"

namespace parray::commands {
namespace {

using nlohmann::json;

constexpr std::size_t most_views = 16;

void check_scene(const std::string& scene) {
  PackedFile file(scene);
  if (particle_format_of(file) == nullptr) {
    throw InputError("--views: " + printable(scene, 4096) +
                     " is not a particle file, and a scene file has one camera: leave out --views");
  }
}

void check_size(const SheetLayout& layout, const RenderSettings& settings,
                const std::filesystem::path& file) {
  const std::uint64_t width = sheet_width(layout, settings.width);
  const std::uint64_t height = sheet_height(layout, settings.height);
  check_image_size(file, width, height);
  if (width <= limits::max_image_side && height <= limits::max_image_side &&
      width * height <= limits::max_pixels) {
    return;
  }
  throw InputError("--views: the picture of all views would have " + std::to_string(width) + " x " +
                   std::to_string(height) +
                   " pixels, too many: use a smaller --width and --height");
}

double joining_seconds(const PictureSize& sheet) {
  constexpr double a_pixel = 20e-9;
  return a_pixel * static_cast<double>(sheet.width * sheet.height);
}

/// Renders the views as jobs of one farm in this process.
class Views {
 public:
  Views(const RenderRequest& request, std::size_t count, Time started)
      : request_(request),
        count_(count),
        started_(started),
        farm_(request.threads,
              [this](const std::string& scene_id) {
                return denoised_judge(prepared_.extra, scene_id);
              }),
        link_(farm_.connect()),
        client_(*link_, clock_, embedded_client(farm_)) {}

  void add(View view) {
    const Time begin = clock_.now();
    RenderRequest request = request_;
    request.view = view;
    prepared_ = prepare(request);
    const RenderSettings& settings = prepared_.submission.settings;
    layout_ = sheet_layout(count_, settings.width, settings.height);
    check_size(layout_, settings, prepared_.outputs.image);
    prepared_.extra.accelerators = farm_.accelerators();
    if (settings.time_limit > 0) share_time(begin);
    const JobId job = client_.submit(std::move(prepared_.submission));
    wait_until_done(client_, job, request_.following);
    Picture picture = fetch_picture(client_, job, prepared_.outputs);
    add_channels(picture, prepared_.extra);
    shown_.push_back(finished_picture(picture, prepared_.outputs.finishing));
    shown_.back().written = shown_.back().traced = nullptr;  // the picture ends here
    reports_.push_back({{"view", name_of(view)}});
    reports_.back().update(picture.report);
  }

  void stop() { stop_interrupted(farm_); }
  [[nodiscard]] Image sheet() const { return sheet_of(shown_, layout_); }
  [[nodiscard]] const json& reports() const { return reports_; }
  [[nodiscard]] double elapsed() const { return to_seconds(clock_.now() - started_); }
  /// Returns the time limit of the whole command in seconds. 0: no limit.
  [[nodiscard]] double limit() const { return limit_; }

 private:
  /// Divides the remaining time equally among this view and the following ones, so that they get
  /// the time that earlier views did not use. `begin`: when work on this view began.
  void share_time(Time begin) {
    RenderSettings& settings = prepared_.submission.settings;
    limit_ = settings.time_limit;
    const PictureSize sheet{sheet_width(layout_, settings.width),
                            sheet_height(layout_, settings.height), 0};
    share_.name = "--time-limit " + number_cell(limit_);
    share_.parts = static_cast<double>(count_ - shown_.size());
    share_.elsewhere = to_seconds(begin - started_) +
                       writing_seconds(prepared_.outputs, sheet, limit_) + joining_seconds(sheet);
    share_.seconds = (limit_ - share_.elsewhere) / share_.parts;
    share_.elapsed = [this, begin] { return to_seconds(clock_.now() - begin); };
    settings.time_limit = std::max(share_.seconds, ranges::time_limit.least);
    const double lacking = settings.time_limit - share_.seconds;
    prepared_.submission.reserved_seconds = lacking + reserve_time(share_, prepared_);
  }

  const RenderRequest& request_;
  const std::size_t count_;  ///< number of views
  const Time started_;
  double limit_ = 0;
  TimeShare share_;  ///< of the current view
  SteadyClock clock_;
  PreparedRender prepared_;  ///< of the current view
  EmbeddedFarm farm_;
  std::unique_ptr<Link> link_;
  Client client_;
  SheetLayout layout_;
  std::vector<ShownPicture> shown_;
  json reports_ = json::array();
};

int write_sheet(const Views& views, const OutputPaths& outputs) {
  const Image sheet = views.sheet();
  ImageMetadata metadata{{"Software", "ParRay " PARRAY_VERSION}};
  std::string hashes;
  std::uint64_t nonfinite = 0;
  for (const json& report : views.reports()) {
    const auto name = report.at("view").get<std::string>();
    hashes += (hashes.empty() ? "" : ", ") + name + " " +
              report.at("image_sha256").get<std::string>().substr(0, 16);
    metadata.emplace_back("parray:view:" + name, report.at("image_sha256").get<std::string>());
    nonfinite += report.at("nonfinite_samples").get<std::uint64_t>();
  }
  if (outputs.dpi > 0) metadata.emplace_back(dpi_key, outputs.dpi);
  const double writing = write_seconds(outputs.image, {sheet.width, sheet.height, 0}, false);
  const bool fast = views.limit() > 0 && views.elapsed() + writing > views.limit();
  write_image(outputs.image, sheet, metadata, {}, check_interrupted, fast);
  const double seconds = views.elapsed();
  if (!outputs.report.empty()) {
    const json report = {{"width", sheet.width},
                         {"height", sheet.height},
                         {"views", views.reports()},
                         {"seconds", {{"total", seconds}}}};
    write_text_file(outputs.report, json_document(report));
  }
  std::cout << "wrote " << outputs.image.string() << ": " << sheet.width << " x " << sheet.height
            << " pixels, " << counted(views.reports().size(), "view") << ", "
            << duration_text(seconds) << ", image_sha256 " << hashes << "\n";
  if (nonfinite == 0) return 0;
  std::cerr << "parray: warning: " << nonfinite
            << " samples were not finite and were left out of the picture: please send the file "
               "of particles to the developers of ParRay\n";
  return 1;
}

std::vector<View> views_from(const std::string& text, AutoSceneOptions& scene) {
  std::vector<View> views;
  for (const std::string_view part : split_at(',', text)) {
    const View view = scene.named_view(part);
    if (std::ranges::find(views, view) != views.end()) {
      throw InputError("'" + std::string(name_of(view)) + "' occurs twice: leave one out");
    }
    views.push_back(view);
  }
  if (views.size() > most_views) {
    throw InputError("more than " + std::to_string(most_views) +
                     " views do not fit into one picture: make two pictures");
  }
  return views;
}

int render_views(const RenderRequest& request, const std::vector<View>& views) {
  const Time started = SteadyClock().now();
  const OutputPaths outputs = request.output.paths();
  check_request(request);
  check_outputs(outputs, inputs_of(request));
  check_scene(request.scene);
  const DeferredInterrupts deferred;
  Views rendered(request, views.size(), started);
  try {
    for (const View view : views) rendered.add(view);
  } catch (const Interrupted&) {
    rendered.stop();
    throw;
  }
  const int status = write_sheet(rendered, outputs);
  ignore_signals();
  return status;
}

struct RenderCommand {
  std::string scene;
  RenderOptions render;
  OutputOptions output;
  std::optional<std::uint32_t> threads;
  ProgressOptions following;
  std::vector<View> views;
};

RenderRequest request_of(const RenderCommand& command, RenderMode mode) {
  return {.mode = mode,
          .scene = command.scene,
          .render = command.render,
          .output = command.output,
          .following = command.following,
          .threads = command.threads.value_or(static_cast<std::uint32_t>(usable_cpus()))};
}

/// Traces a part of the picture. Prints a line on stderr if denoising is not expected to pay
/// (cli/measure/plan/denoising_worth.h).
void warn_if_denoising_does_not_pay(const ExtraChannels& extra) {
  const auto tracer = tracer_of(extra, scene_identity(*extra.scene));
  const auto worth = denoising_worth(*tracer, *extra.scene, extra.settings, extra.threads);
  if (worth && !worth->pays()) std::cerr << "parray: " + denoising_does_not_pay(*worth) + "\n";
}

int render(const RenderCommand& command) {
  if (!command.views.empty()) {
    return render_views(request_of(command, RenderMode::sheet), command.views);
  }
  const SteadyClock clock;
  const Time started = clock.now();
  const RenderRequest request = request_of(command, RenderMode::render);
  PreparedRender prepared = prepare(request);
  ExtraChannels& extra = prepared.extra;
  const DeferredInterrupts deferred;
  EmbeddedFarm farm(request.threads, [&extra](const std::string& scene_id) {
    return denoised_judge(extra, scene_id);
  });
  extra.accelerators = farm.accelerators();
  if (command.output.paths().denoise && !command.following.quiet) {
    warn_if_denoising_does_not_pay(extra);
  }
  reserve_time(prepared, [&] { return to_seconds(clock.now() - started); });
  const auto link = farm.connect();
  Client client(*link, clock, embedded_client(farm));
  try {
    const Time submitted = clock.now();
    const JobId job = client.submit(std::move(prepared.submission));
    const int status =
        wait_and_write(client, job, prepared.outputs, command.following, extra,
                       CommandTimes{started, to_seconds(clock.now() - submitted), true});
    ignore_signals();
    return status;
  } catch (const Interrupted&) {
    stop_interrupted(farm);
    throw;
  }
}

}  // namespace

void add_render(CommandLine& line) {
  Command command = line.command("render", "Render a scene on this machine");
  const auto options = std::make_shared<RenderCommand>();
  add_scene(command, options->scene);
  options->render.add_to(command);
  options->render.add_quality_to(command);
  options->render.add_like_to(command);
  add_threads(command, options->threads).group(work_group);
  command
      .option(
          "--views",
          [options](const std::string& text) {
            options->views = views_from(text, options->render.auto_scene());
          },
          "Draw several views, such as front,top,iso, in one picture (not EXR), in rows that make "
          "it about twice as wide as high. --width and --height are the size of one view")
      .words(view_words(), true)
      .type_name("VIEW,VIEW...")
      .group(particles_group);
  options->output.add_to(command, true);
  options->output.add_aov_to(command);
  options->output.add_denoise_to(command);
  options->output.add_labels_to(command, options->render);
  add_following(command, options->following);
  command.example("parray render scenes/glass.json -o glass.png",
                  "uses the settings of the scene, and shows progress");
  command.example("parray render scenes/particles/helix.pdb -o helix.png",
                  "shows a molecule; ParRay chooses camera and light");
  command.example(
      "parray render scenes/particles/helix.pdb -o helix.png --legend --scale-bar --width-mm 85",
      "for print, one column wide, with a legend of the colours and a scale bar");
  command.example(
      "parray render scenes/particles/helix.pdb -o views.png --views front,top,iso "
      "--style publication",
      "shows three sides, for a paper: white background, outlines");
  command.example("parray render scenes/particles/helix.pdb -o helix.png --quality draft",
                  "a small, denoised picture in a moment; print: a large one with little noise");
  command.example("parray render scenes/glass.json -o glass.exr --target-error 0.01",
                  "stops when the error is at most 0.01 (RMSE, linear radiance)");
  command.example("parray render scenes/glass.json -o glass.png --time-limit 10 --denoise",
                  "makes the best picture possible in ten seconds, and denoises it");
  command.example(
      "parray render scenes/glass.json -o glass.exr --aov depth,normal --report glass.json",
      "adds channels for depth and normals, and writes a report");
  command.runs([options] { return render(*options); });
}

}  // namespace parray::commands
