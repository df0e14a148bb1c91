#include "cli/commands/time_reserve.h"

#include <algorithm>
#include <iostream>
#include <utility>

#include "cli/output/ending_cost.h"
#include "cli/output/text.h"
#include "common/scene/scene_bytes.h"
#include "coordinator/jobs/report.h"

namespace parray::commands {
namespace {

/// Seconds for drawing on the picture and its map.
double drawing_seconds(const OutputPaths& outputs, double pixels) {
  constexpr double finishing_a_pixel = 150e-9;
  constexpr double map_a_pixel = 100e-9;
  return (outputs.error_map.empty() ? 0 : map_a_pixel * pixels) +
         (outputs.finishing.empty() ? 0 : finishing_a_pixel * pixels);
}

void say(const TimeShare& share, const std::string& text) {
  std::cerr << "parray: " + share.name + ": " + text + "\n";
}

void leave_out(TimeShare& share, bool TimeShare::*said, const char* what, double seconds) {
  if (!(share.*said))
    say(share, what + (" takes about " + duration_text(seconds)) + " more: left out");
  share.*said = true;
}

}  // namespace

void reserve_time(PreparedRender& render, std::function<double()> elapsed) {
  const RenderSettings& settings = render.submission.settings;
  const double limit = settings.time_limit;
  if (limit <= 0) return;
  const OutputPaths& outputs = render.outputs;
  const std::size_t channels =
      (settings.adaptive ? 1U : 0U) + (outputs.transparent ? 1U : 0U) + (outputs.denoise ? 3U : 0U);
  TimeShare share = {limit, "--time-limit " + number_cell(limit),
                     writing_seconds(outputs, {settings.width, settings.height, channels}, limit),
                     std::move(elapsed)};
  render.submission.reserved_seconds = reserve_time(share, render);
}

double writing_seconds(const OutputPaths& outputs, const PictureSize& size, double limit) {
  // The system starts the process before `main`, and frees its memory at the end.
  constexpr double outside = 0.02;
  constexpr double outside_a_pixel = 8e-9;
  const auto pixels = static_cast<double>(size.width * size.height);
  const auto writing = [&](const std::filesystem::path& file, bool fast) {
    return file.empty() ? 0 : write_seconds(file, size, fast);
  };
  const double image = writing(outputs.image, false);
  const bool haste = image > limit / 10;
  return outside + outside_a_pixel * pixels + (haste ? writing(outputs.image, true) : image) +
         writing(outputs.preview, false) + writing(outputs.error_map, false);
}

double reserve_time(TimeShare& share, PreparedRender& render) {
  auto& [submission, outputs, extra] = render;
  RenderSettings& settings = submission.settings;
  constexpr double most = 0.85;  // of the limit: the rest is for tracing
  const EndingCost cost =
      extra.scene ? ending_cost(extra, scene_identity(*submission.scene)) : EndingCost();
  const double ending = ending_times(settings, 0, 0).total;  // which others reserve
  const double pixels = static_cast<double>(settings.width) * settings.height;
  double reserved = share.elapsed() + share.writing + drawing_seconds(outputs, pixels);
  const auto add_if_it_fits = [&](double needed) {
    const bool fits = reserved + ending + needed <= most * share.seconds;
    reserved += fits ? needed : 0;
    return fits;
  };
  if (outputs.denoise && (share.without_denoising || !add_if_it_fits(cost.denoising))) {
    leave_out(share, &TimeShare::without_denoising, "denoising", cost.denoising * share.parts);
    outputs.denoise = extra.denoise = settings.replicates = settings.target_denoised = false;
    extra.settings = settings;
  }
  if (cost.channels > 0 && (share.without_channels || !add_if_it_fits(cost.channels))) {
    leave_out(share, &TimeShare::without_channels, "tracing extra channels",
              cost.channels * share.parts);
    outputs.aovs = extra.aovs = extra.for_finishing = {};
    std::erase_if(outputs.finishing, [](const FinishingStep& step) { return !step.needs.empty(); });
  }
  if (reserved + ending > share.seconds && !share.without_time) {
    share.without_time = true;
    const double least = share.elsewhere + share.parts * (reserved + ending);
    say(share, "loading and writing alone take about " + duration_text(least) +
                   ": as little as possible is traced");
  }
  const double left = std::max(share.seconds - reserved - ending, 0.0);
  return reserved + left * cost.background_share / (1 + cost.background_share);
}

}  // namespace parray::commands
