#include "cli/commands/render_views.h"

#include <algorithm>
#include <iostream>
#include <nlohmann/json.hpp>
#include <utility>

#include "cli/commands/rendering.h"
#include "cli/commands/time_reserve.h"
#include "cli/farm/embedded.h"
#include "cli/input/formats/format_table.h"
#include "cli/input/particles/packed_file.h"
#include "cli/output/denoising.h"
#include "cli/output/picture/image_file.h"
#include "cli/output/picture/partial_file.h"
#include "cli/output/postprocess/sheet.h"
#include "cli/output/text.h"
#include "common/base/error.h"
#include "common/base/printable.h"
#include "common/process/stop_signal.h"
#include "common/scene/limits.h"
#include "common/scene/scene_bytes.h"
#include "common/scene/scene_ranges.h"

namespace parray::commands {
namespace {

using nlohmann::json;

constexpr std::size_t most_views = 16;

/// What only one picture can have.
void check(const ViewsRequest& request, const OutputPaths& outputs) {
  const auto refuse = [](const std::string& what) {
    throw InputError("--views: " + what + ": leave it out, or render views one by one with --view");
  };
  if (can_hold_channels(outputs.image)) {
    throw InputError("--views: " + outputs.image.string() +
                     ": a sheet of views is to be looked at: write a PNG file (.png), or an EXR "
                     "file of each with --view");
  }
  if (!outputs.error_map.empty()) refuse("--error-map is of one picture");
  if (request.following.shows_picture()) refuse("--preview and --display show one picture");
  if (!request.following.on_end.empty()) refuse("--on-end is of one picture");
  if (!request.render.like().empty()) refuse("--like is of one picture");
  if (request.render.portrait().has_view()) refuse("--view is one of them");
  if (request.scene == standard_input_argument) {
    throw InputError(
        "--views: each view reads the file, and standard input can be read once: save it");
  }
  PackedFile file(request.scene);
  if (particle_format_of(file) == nullptr) {
    throw InputError("--views: " + printable(request.scene, 4096) +
                     " is not a file of particles: it has its own camera");
  }
}

void check_size(const SheetLayout& layout, const RenderSettings& settings) {
  const std::uint64_t width = sheet_width(layout, settings.width);
  const std::uint64_t height = sheet_height(layout, settings.height);
  if (width <= limits::max_image_side && height <= limits::max_image_side &&
      width * height <= limits::max_pixels) {
    return;
  }
  throw InputError("--views: the sheet would have " + std::to_string(width) + " x " +
                   std::to_string(height) +
                   " pixels, too many: use a smaller --width and --height");
}

/// For putting the pictures of a sheet together.
double joining_seconds(const PictureSize& sheet) {
  constexpr double a_pixel = 20e-9;
  return a_pixel * static_cast<double>(sheet.width * sheet.height);
}

/// Renders the views, each as a job of one farm in this process.
class Views {
 public:
  Views(const ViewsRequest& request, const OutputPaths& outputs, Time started)
      : request_(request),
        outputs_(outputs),
        started_(started),
        farm_(request.threads,
              [this](const std::string& scene_id) { return denoised_judge(extra_, scene_id); }),
        link_(farm_.connect()),
        client_(*link_, clock_, embedded_client(farm_)) {}

  void add(View view) {
    const Time begin = clock_.now();
    RenderOptions render = request_.render;
    render.portrait().look_from(view);
    OutputPaths outputs = outputs_;
    SceneFile file;
    Submission submission =
        load_for_outputs(request_.scene, render, 50, request_.output, outputs, file);
    check_isa(submission.settings.isa);
    layout_ =
        sheet_layout(request_.views.size(), submission.settings.width, submission.settings.height);
    check_size(layout_, submission.settings);
    if (outputs.denoise) ask_for_denoising(submission.settings, true);
    extra_ = extra_channels(outputs.aovs, submission.settings, submission.scene,
                            static_cast<int>(request_.threads), outputs.transparent,
                            needs_of(outputs.finishing));
    extra_.accelerators = farm_.accelerators();
    if (submission.settings.time_limit > 0) share_time(begin, submission, outputs);
    const JobId job = client_.submit(std::move(submission));
    wait_until_done(client_, job, request_.following);
    Picture picture = fetch_picture(client_, job, outputs);
    add_channels(picture, extra_);
    shown_.push_back(finished_picture(picture, outputs.finishing));
    shown_.back().written = shown_.back().traced = nullptr;  // of a picture that is gone
    reports_.push_back({{"view", name_of(view)}});
    reports_.back().update(picture.report);
  }

  void stop() { stop_interrupted(farm_); }
  [[nodiscard]] Image sheet() const { return sheet_of(shown_, layout_); }
  [[nodiscard]] const json& reports() const { return reports_; }
  [[nodiscard]] double elapsed() const { return to_seconds(clock_.now() - started_); }
  /// Seconds that the whole command may take; 0: as many as it needs.
  [[nodiscard]] double limit() const { return limit_; }

 private:
  /// Gives this view and each that follows the same part of the time that is left, so that what a
  /// view leaves unused goes to the next. `begin`: when work on this view began.
  void share_time(Time begin, Submission& submission, OutputPaths& outputs) {
    RenderSettings& settings = submission.settings;
    limit_ = settings.time_limit;
    const PictureSize sheet{sheet_width(layout_, settings.width),
                            sheet_height(layout_, settings.height), 0};
    share_.name = "--time-limit " + number_cell(limit_);
    share_.parts = static_cast<double>(request_.views.size() - shown_.size());
    share_.elsewhere = to_seconds(begin - started_) + writing_seconds(outputs, sheet, limit_) +
                       joining_seconds(sheet);
    share_.seconds = (limit_ - share_.elsewhere) / share_.parts;
    share_.elapsed = [this, begin] { return to_seconds(clock_.now() - begin); };
    settings.time_limit = std::max(share_.seconds, ranges::time_limit.least);
    const double lacking = settings.time_limit - share_.seconds;
    submission.reserved_seconds = lacking + reserve_time(share_, outputs, settings, extra_,
                                                         scene_identity(*submission.scene));
  }

  const ViewsRequest& request_;
  const OutputPaths& outputs_;
  const Time started_;
  double limit_ = 0;
  TimeShare share_;  ///< of the view that is being rendered
  SteadyClock clock_;
  ExtraChannels extra_;  ///< of the view that is being rendered
  EmbeddedFarm farm_;
  std::unique_ptr<Link> link_;
  Client client_;
  SheetLayout layout_;
  std::vector<ShownPicture> shown_;
  json reports_ = json::array();
};

/// Writes sheet and report, and says so.
int deliver_sheet(const Views& views, const OutputPaths& outputs) {
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
    write_text_file(outputs.report, report.dump(2) + "\n");
  }
  std::cout << "wrote " << outputs.image.string() << ": " << sheet.width << " x " << sheet.height
            << " pixels, " << counted(views.reports().size(), "view") << ", "
            << duration_text(seconds) << ", image_sha256 " << hashes << "\n";
  if (nonfinite == 0) return 0;
  std::cerr << "parray: warning: " << nonfinite
            << " samples were not finite and were left out of the sheet: please report the scene\n";
  return 1;
}

}  // namespace

std::vector<View> views_from(const std::string& text) {
  std::vector<View> views;
  std::size_t begin = 0;
  while (begin <= text.size()) {
    const std::size_t end = std::min(text.find(',', begin), text.size());
    const View view = view_from(text.substr(begin, end - begin));
    if (std::find(views.begin(), views.end(), view) != views.end()) {
      throw InputError("'" + std::string(name_of(view)) + "' stands there twice: leave one out");
    }
    views.push_back(view);
    begin = end + 1;
  }
  if (views.size() > most_views) {
    throw InputError("more than " + std::to_string(most_views) + " views: make two sheets");
  }
  return views;
}

int render_views(const ViewsRequest& request) {
  const Time started = SteadyClock().now();
  const OutputPaths outputs = request.output.paths(request.following);
  check_outputs(outputs, request.scene);
  check(request, outputs);
  const DeferredInterrupts deferred;
  Views views(request, outputs, started);
  try {
    for (const View view : request.views) views.add(view);
  } catch (const Interrupted&) {
    views.stop();
    throw;
  }
  return deliver_sheet(views, outputs);
}

}  // namespace parray::commands
