#include "cli/commands/prepare.h"

#include <algorithm>
#include <array>
#include <filesystem>
#include <iostream>
#include <utility>
#include <vector>

#include "cli/commands/finishing_options.h"
#include "cli/commands/frame_scenes.h"
#include "cli/commands/printing.h"
#include "cli/commands/time_reserve.h"
#include "cli/input/particles/packed_file.h"
#include "cli/output/picture/image_file.h"
#include "cli/output/recipe.h"
#include "common/adaptive/rounding_limit.h"
#include "common/base/cpu_count.h"
#include "common/base/error.h"
#include "common/base/printable.h"
#include "common/scene/largest_radiance.h"
#include "common/scene/requirements.h"
#include "common/scene/scene_bytes.h"
#include "common/scene/settings.h"
#include "common/trace/isa.h"

namespace parray::commands {
namespace {

struct Rules {
  const char* what;            ///< name for messages
  const char* remedy;          ///< usual remedy
  std::vector<Feature> lacks;  ///< features that the mode does not support
};

/// Returns the rules of each RenderMode, in its order.
const std::array<Rules, 9>& rules() {
  using enum Feature;
  static const std::array<Rules, 9> all = {{
      {"parray render", "", {}},
      {"parray-mpi", "", {denoised_target}},
      {"pictures of a farm", "", {denoised_target}},
      {"parray submit without a picture file",
       "add --wait -o IMAGE, or --transparent off",
       {denoised_target, transparency, background, postprocessing}},
      {"one picture of several views (--views)",
       "leave it out, or render the views one by one with --view",
       {preview, end_command, error_map, exr_file, traced_channels, like, view, standard_input}},
      {"a series of frames",
       "leave it out, or render the frames one by one",
       {denoising, denoised_target, transparency, background, labels, postprocessing, preview, like,
        traced_channels, standard_input}},
      {"pictures by HTTP", "leave it out, or use parray render", {denoised_target, transparency}},
      {"parray fetch, which has no scene",
       "leave it out, or use parray render, or parray submit --wait",
       {traced_channels}},
      {"a film",
       "use --transparent off or, for a file of particles, --background COLOR instead",
       {denoised_target, transparency}},
  }};
  return all;
}

const Rules& rules_of(RenderMode mode) { return rules()[static_cast<std::size_t>(mode)]; }

std::string remedy_of(RenderMode mode, Feature feature) {
  switch (feature) {
    case Feature::denoised_target:
      return mode == RenderMode::http
                 ? "give spp instead of target_error, or set denoise to false"
                 : "use parray render, or give --spp instead of --target-error";
    case Feature::exr_file:
      return "write a .png, .tif, .jpg or .jp2, or an EXR file of each with --view";
    case Feature::transparency:
      if (mode != RenderMode::series) break;
      return "add --transparent off, or render the frames one by one";
    case Feature::background:
      return mode == RenderMode::submit ? "add --wait -o IMAGE.png, or leave it out"
                                        : "leave it out, or render the frames one by one";
    case Feature::standard_input: return "standard input can be read only once: save it as a file";
    default: break;
  }
  return rules_of(mode).remedy;
}

/// Loads the scene. With --like, uses the settings of its recipe, and sets what `loaded` keeps of
/// its picture.
SceneFile load_like(const std::string& scene_file, RenderOptions options, const FrameChange& change,
                    NamedFiles named, LoadedSubmission& loaded) {
  if (options.like().empty()) return load_scene(scene_file, options, change, named);
  options.check_like();
  const std::string picture = printable(options.like(), 4096);
  const Recipe recipe = recipe_in(read_image(options.like()).metadata, picture);
  options.follow(recipe.settings, !recipe.transparent_sha256.empty());
  SceneFile file = load_scene(scene_file, options, {}, named);
  check_recipe(recipe, picture, scene_identity(file.scene), printable(scene_file, 4096));
  loaded.original_sha256 = recipe.image_sha256;
  loaded.original_denoised = !recipe.denoised_sha256.empty();
  return file;
}

OutputPaths output_paths_of(const RenderRequest& request, const LoadedSubmission& loaded) {
  const Submission& submission = loaded.submission;
  OutputPaths outputs = request.output.paths(request.following);
  outputs.notes = notes_json(loaded.rest.particle_files);
  outputs.transparent = loaded.rest.transparent;
  const Quality* const quality = request.render.quality();
  const bool may_denoise = !outputs.image.empty() && submission.settings->samples_per_pixel >= 2 &&
                           can_have(request.mode, Feature::denoising);
  outputs.denoise = outputs.denoise || (quality != nullptr && quality->denoise && may_denoise);
  outputs.original = {printable(request.render.like(), 4096), loaded.original_sha256};
  const bool has_picture = !outputs.image.empty() || request.mode == RenderMode::submit;
  if (loaded.original_denoised && !outputs.denoise && has_picture) {
    std::cerr << "parray: --like " << outputs.original.file
              << ": this picture is denoised, the new one is not: add --denoise to repeat that\n";
  }
  if (outputs.transparent && !loaded.rest.background && !outputs.image.empty() &&
      !can_hold_alpha(outputs.image)) {
    throw InputError(outputs.image.string() +
                     ": JPEG has no transparency: write .png, .tif, .jp2 or .exr");
  }
  add_labels(outputs, request.output.labels(), loaded.rest, submission.settings);
  add_postprocessing(outputs, request.output.postprocessing(), loaded.rest, submission.scene,
                     submission.settings);
  if (loaded.rest.background) add_background(outputs, *loaded.rest.background);
  return outputs;
}

bool traces_here(RenderMode mode) {
  return mode == RenderMode::render || mode == RenderMode::mpi || mode == RenderMode::sheet;
}

}  // namespace

bool can_have(RenderMode mode, Feature feature) {
  return std::ranges::count(rules_of(mode).lacks, feature) == 0;
}

void require(RenderMode mode, Feature feature, const std::string& name) {
  if (can_have(mode, feature)) return;
  throw InputError(name + ": not possible for " + rules_of(mode).what + ": " +
                   remedy_of(mode, feature));
}

void ask_for_denoising(RenderSettings& settings, RenderMode mode, bool usual) {
  settings.replicates = true;
  settings.target_denoised = settings.target_error > 0 && settings.passes.empty() &&
                             !(usual && !can_have(mode, Feature::denoised_target));
  if (!settings.target_denoised) return;
  require(mode, Feature::denoised_target, "--target-error with --denoise");
  if (settings.target_half_width > 0) {
    throw InputError(
        "--target-error with --denoise excludes --target-half-width: a denoised picture has no "
        "half-widths: leave one of the three out");
  }
}

namespace {

/// Makes a submission of the scene of `scene_file`, which `load` loads. `load` may also set the
/// other members of its argument.
LoadedSubmission submission_of(RenderMode mode, const std::string& scene_file,
                               std::uint32_t priority, const auto& load) {
  const SteadyClock clock;
  const Time begin = clock.now();
  LoadedSubmission loaded;
  loaded.rest = load(loaded);
  Submission& submission = loaded.submission;
  SceneFile& file = loaded.rest;
  const ResolvedSettings resolved =
      resolve_settings(requirements_of(file.scene, usable_cpus()), file.settings);
  submission.scene = std::make_shared<const Scene>(std::exchange(file.scene, {}));
  file.scene.camera = submission.scene->camera;
  check_targets(resolved.settings, largest_radiance(*submission.scene));
  submission.name = scene_file == standard_input_argument
                        ? "standard input"
                        : printable(std::filesystem::path(scene_file).filename().string(), 100);
  const bool draws_background = mode == RenderMode::http || mode == RenderMode::film;
  const bool only_replaced = draws_background && file.background;
  if (file.transparent && !only_replaced) {
    require(mode, Feature::transparency, submission.name + ": transparent");
  }
  submission.priority = priority;
  submission.settings = resolved.settings;
  submission.precision_reason = resolved.precision_reason;
  submission.duplicates_removed = file.duplicates.count;
  submission.load_seconds = to_seconds(clock.now() - begin);
  return loaded;
}

}  // namespace

LoadedSubmission load_submission(RenderMode mode, const std::string& scene_file,
                                 const RenderOptions& options, std::uint32_t priority,
                                 const FrameChange& change) {
  const NamedFiles named = mode == RenderMode::http ? NamedFiles::beside : NamedFiles::anywhere;
  return submission_of(mode, scene_file, priority, [&](LoadedSubmission& loaded) {
    return load_like(scene_file, options, change, named, loaded);
  });
}

LoadedSubmission load_frame(RenderMode mode, FrameScenes& scenes, std::uint32_t frame,
                            std::uint32_t priority, const std::function<void(SceneFile&)>& change) {
  return submission_of(mode, scenes.file(), priority, [&](const LoadedSubmission& /*loaded*/) {
    SceneFile scene = scenes.at(frame);
    if (change) change(scene);
    return scene;
  });
}

void check_request(const RenderRequest& request) {
  const OutputPaths outputs = request.output.paths(request.following);
  const auto check = [&](bool asked, Feature feature, const std::string& name) {
    if (asked) require(request.mode, feature, name);
  };
  const auto check_given = [&](const std::string& option, Feature feature) {
    check(!option.empty(), feature, option);
  };
  Aovs traced = outputs.aovs;
  if (can_have(request.mode, Feature::exr_file)) std::erase_if(traced, is_statistic);
  check(can_hold_channels(outputs.image), Feature::exr_file, outputs.image.string());
  check(!traced.empty(), Feature::traced_channels, "--aov " + text_of(traced));
  check(!outputs.error_map.empty(), Feature::error_map, "--error-map");
  check(outputs.denoise, Feature::denoising, "--denoise");
  check(request.render.transparent(false), Feature::transparency, "--transparent");
  if (request.render.auto_scene().background()) {
    check(true, Feature::background, "--background");
    if (request.render.transparent(false)) {
      throw InputError(
          "--background and --transparent exclude each other: a transparent picture has no "
          "background");
    }
  }
  check_given(request.output.labels().first_given(), Feature::labels);
  check_given(request.output.postprocessing().first_given(), Feature::postprocessing);
  check(!outputs.preview.empty(), Feature::preview, "--preview");
  check(!request.following.display.empty(), Feature::preview, "--display");
  check(!request.following.on_end.empty(), Feature::end_command, "--on-end");
  check(!request.render.like().empty(), Feature::like, "--like");
  check(request.render.auto_scene().has_view(), Feature::view, "--view");
  check(request.scene == standard_input_argument, Feature::standard_input, "-");
}

InputFiles inputs_of(const RenderRequest& request) {
  return {request.scene, request.render.particles().topology(), request.render.like(),
          request.key_file};
}

PreparedRender prepare(const RenderRequest& request) {
  check_request(request);
  check_outputs(request.output.paths(request.following), inputs_of(request));
  check_display(request.following.display);
  RenderOptions options = request.render;
  if (request.view) options.auto_scene().look_from(*request.view);
  LoadedSubmission loaded = load_submission(request.mode, request.scene, options, request.priority);
  OutputPaths outputs = output_paths_of(request, loaded);
  check_not_inputs(outputs, inputs_of(loaded.rest));
  Submission& submission = loaded.submission;
  RenderSettings& settings = submission.settings;
  if (request.mode != RenderMode::sheet) {  // whose picture contains several of this size
    check_image_size(outputs.image, settings.width, settings.height);
    check_image_size(outputs.preview, settings.width, settings.height);
  }
  if (!can_have(request.mode, Feature::postprocessing)) {
    warn_of_missing_postprocessing(loaded.rest.postprocessing, false, submission.name,
                                   "add --wait -o IMAGE.png to have them");
  }
  if (traces_here(request.mode)) check_isa(settings.isa);
  settings.progressive = request.following.shows_picture();
  if (outputs.denoise) {
    ask_for_denoising(settings, request.mode, !request.render.has_target_error());
    submission.denoise = request.mode == RenderMode::wait || request.mode == RenderMode::submit;
  }
  ExtraChannels extra =
      extra_channels(outputs, settings, submission.scene, static_cast<int>(request.threads));
  return {std::move(submission), std::move(outputs), std::move(extra)};
}

void check_isa(Isa isa) {
  if (!runs_on_this_machine(isa)) {
    throw InputError("--isa " + std::string(name_of(isa)) +
                     ": this processor lacks this instruction set: use " +
                     std::string(name_of(best_isa())) + ", its best, or auto");
  }
}

}  // namespace parray::commands
