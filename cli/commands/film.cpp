#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <iostream>
#include <limits>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "cli/commands/commands.h"
#include "cli/commands/drawing.h"
#include "cli/commands/farm.h"
#include "cli/commands/film_folder.h"
#include "cli/commands/finishing_options.h"
#include "cli/commands/frame_scenes.h"
#include "cli/commands/options.h"
#include "cli/commands/prepare.h"
#include "cli/commands/printing.h"
#include "cli/commands/rendering.h"
#include "cli/commands/series.h"
#include "cli/farm/embedded.h"
#include "cli/input/view/auto_scene.h"
#include "cli/output/picture/partial_file.h"
#include "cli/output/progress.h"
#include "cli/output/text.h"
#include "common/base/cpu_count.h"
#include "common/base/error.h"
#include "common/base/files.h"
#include "common/base/json_text.h"
#include "common/base/printable.h"
#include "common/process/stop_signal.h"
#include "common/scene/limits.h"
#include "common/scene/settings.h"

namespace parray::commands {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

constexpr const char* film_group = "Frames";
constexpr const char* denoise_option = "--denoise";

struct FilmCommand {
  FilmCourse course;
  std::string film;
  std::string report;
  RenderOptions render;
  LabelOptions labels;
  PostprocessOptions postprocessing;
  bool denoise = false;
  bool moving_noise = false;
  double per_second = 25;
  bool on_farm = false;
  FarmOptions farm;
  std::uint32_t priority = 50;
  std::optional<std::uint32_t> threads;
  ProgressOptions following;
  std::optional<Command> declared;  ///< the command that has these options
};

/// Returns the options that determine the pictures, as a text.
std::string request_of(const FilmCommand& command, const FilmFrames& frames) {
  std::string text = "ParRay " PARRAY_VERSION "\n";
  for (const GivenOption& given : command.declared->given_options()) {
    const std::string& group = given.group;
    const bool decides = group == settings_group || group == limits_group ||
                         group == particles_group || group == labels_group ||
                         group == postprocess_group || group == film_group ||
                         given.name == denoise_option || given.name == "--transparent";
    text += decides ? given.name + "=" + given.value + "\n" : "";
  }
  for (const std::uint32_t number : frames.numbers()) text += std::to_string(number) + " ";
  return text;
}

/// Returns the input files that the command line names, and `files`. Throws InputError if film or
/// report is one of them.
InputFiles checked_inputs(const FilmCommand& command, const std::vector<std::string>& files = {}) {
  InputFiles inputs{command.course.scene, command.course.camera_path,
                    command.render.particles().topology(), command.farm.key_file()};
  for (const std::string& file : files) inputs.add(file);
  inputs.check(command.film);
  inputs.check(command.report);
  return inputs;
}

bool wants_denoising(const FilmCommand& command, const RenderSettings& settings) {
  const Quality* const quality = command.render.quality();
  return command.denoise ||
         (quality != nullptr && quality->denoise && settings.samples_per_pixel >= 2);
}

bool has_time_limit(const FilmCommand& command) {
  return std::ranges::any_of(command.declared->given_options(),
                             [](const GivenOption& given) { return given.name == "--time-limit"; });
}

/// Returns a function that shows how many frames were read.
FilmFrames::OnRead shown_reading(const ProgressOptions& following) {
  const auto progress = std::make_shared<Progress>(
      progress_style(following.quiet, following.progress), std::cerr, terminal_columns);
  return [progress, clock = SteadyClock(), begin = SteadyClock().now()](std::size_t read,
                                                                        std::size_t all) {
    JobStatus status;
    status.name = "film";
    status.state = "reading";
    status.frames = all;
    status.frames_done = read;
    status.progress = static_cast<double>(read) / static_cast<double>(all);
    status.seconds_left = to_seconds(clock.now() - begin) * (1 / status.progress - 1);
    progress->show(clock.now(), status);
  };
}

class Film {
 public:
  Film(const FilmCommand& command, Time started)
      : command_(command),
        started_(started),
        frames_(command.course, command.render, shown_reading(command.following)),
        files_(frames_.files()),
        inputs_(checked_inputs(command, files_)),
        identity_(film_identity(request_of(command, frames_), files_)),
        folder_(command.film, identity_) {
    for (const std::uint32_t frame : frames_.numbers()) {
      const std::uint32_t place = frames_.place_of(frame);
      inputs_.check(folder_.picture(place));
      inputs_.check(folder_.report(place));
      if (folder_.has(place)) there_.insert(frame);
    }
    if (!there_.empty()) {
      std::cerr << "parray: " << there_.size() << " of " << frames_.count() << " frames are in "
                << folder_text() << " from an earlier run\n";
    }
  }

  /// Renders the frames that are not there. Returns the exit status.
  int render() {
    if (there_.size() == frames_.count()) return 0;
    return command_.on_farm ? render_on_farm() : render_here();
  }

  [[nodiscard]] bool is_complete() const {
    return std::ranges::all_of(frames_.numbers(), [this](std::uint32_t frame) {
      return folder_.has(frames_.place_of(frame));
    });
  }

  /// Makes the film of the frames, writes the report and prints the result. Returns the exit
  /// status.
  int finish() const {
    const json list = folder_.frame_list(frames_.count());
    const json first = json::parse(read_file(folder_.report(0)).value_or("{}"));
    FilmPictures pictures{folder_.path(), frames_.count(), first.at("width"), first.at("height"),
                          command_.per_second};
    const auto lacking = encode(pictures);
    const int status = lacking && !lacking->missing ? 1 : 0;
    write_report(list, pictures, !lacking);
    print_summary(list, pictures, !lacking);
    return status;
  }

 private:
  [[nodiscard]] std::string folder_text() const { return printable(folder_.path().string(), 4096); }

  /// Says that the frames of another film will be replaced. Call it when a frame can be rendered:
  /// until then the film may still be refused.
  void tell_of_other_film() {
    if (std::exchange(told_, true) || !there_.empty() || !folder_.has_other_film()) return;
    std::cerr << "parray: the frames in " << folder_text()
              << " were made with other options, files or another release: rendering all frames "
                 "again\n";
  }

  int render_here() {
    const auto threads = command_.threads.value_or(static_cast<std::uint32_t>(usable_cpus()));
    EmbeddedFarm farm(threads);
    const auto link = farm.connect();
    Client client(*link, clock_, embedded_client(farm));
    try {
      FrameJobs jobs = jobs_for(client);
      // One is traced, one is ready, one is written. Waiting counts for a time limit.
      jobs.most_unfinished = has_time_limit(command_) ? 1 : 3;
      return run_frames(client, jobs);
    } catch (const Interrupted&) {
      stop_interrupted(farm);
      throw;
    }
  }

  int render_on_farm() {
    FarmClient client(command_.farm);
    FrameJobs jobs = jobs_for(*client);
    jobs.token = series_token(identity_);
    return reading_answers([&] { return run_frames(*client, jobs); })();
  }

  FrameJobs jobs_for(Client& client) {
    FrameJobs jobs;
    jobs.frames = frames_.numbers();
    jobs.there = there_;
    jobs.load = [this](std::uint32_t frame) { return load(frame); };
    jobs.deliver = [this, &client](std::uint32_t frame, JobId job) {
      const std::uint32_t place = frames_.place_of(frame);
      OutputPaths outputs;
      outputs.image = folder_.picture(place);
      outputs.report = folder_.report(place);
      outputs.facts = folder_.facts(place, frame);
      outputs.summary = false;
      return fetch_and_write(client, job, outputs);
    };
    jobs.following = command_.following;
    jobs.image = command_.film;
    jobs.prints = false;
    jobs.first_must_load = true;
    return jobs;
  }

  Submission load(std::uint32_t frame) {
    LoadedSubmission loaded =
        load_frame(RenderMode::film, frames_.scenes(), frame, command_.priority,
                   [&](SceneFile& scene) { frames_.move_camera(frame, scene); });
    if (!noted_) print_notes(loaded.rest.particle_files);
    noted_ = true;
    Submission submission = std::move(loaded.submission);
    RenderSettings& settings = submission.settings;
    check_size(settings);
    if (!command_.on_farm) check_isa(settings.isa);
    submission.name = printable(fs::path(command_.film).filename().string(), 100);
    if (command_.moving_noise) settings.seed += frames_.place_of(frame);
    submission.drawing = drawing_text(command_.labels, command_.postprocessing, loaded.rest,
                                      submission.scene, settings);
    submission.denoise = wants_denoising(command_, settings);
    if (submission.denoise) {
      ask_for_denoising(settings, RenderMode::film, !command_.render.has_target_error());
    }
    tell_of_other_film();
    return submission;
  }

  void check_size(const RenderSettings& settings) {
    const std::pair size(settings.width, settings.height);
    if (!size_) size_ = size;
    if (*size_ == size) return;
    throw InputError("it has " + std::to_string(size.first) + " x " + std::to_string(size.second) +
                     " pixels, and another frame has " + std::to_string(size_->first) + " x " +
                     std::to_string(size_->second) + ": give --width and --height");
  }

  [[nodiscard]] std::optional<NoFilm> encode(const FilmPictures& pictures) const {
    const char* const path = std::getenv("PATH");  // NOLINT(concurrency-mt-unsafe): not changed
    auto lacking = encode_film(pictures, command_.film, path == nullptr ? "" : path);
    if (lacking) {
      std::cerr << "parray: no " << printable(command_.film, 4096) << ": " << lacking->why
                << "; the frames are " << printable(folder_.picture(0).string(), 4096) << " to "
                << film_picture(frames_.count() - 1) << "\n";
    } else if (needs_padding(pictures, command_.film)) {
      std::cerr << "parray: .mp4 and .webm films have an even width and height: "
                   "black pixels were added at the edge\n";
    }
    return lacking;
  }

  void write_report(const json& list, const FilmPictures& pictures, bool made) const {
    const json report = {{"film", made ? json(command_.film) : json()},
                         {"frames_folder", folder_.path().string()},
                         {"frames", frames_.count()},
                         {"frames_from_earlier", there_.size()},
                         {"width", pictures.width},
                         {"height", pictures.height},
                         {"frames_per_second", command_.per_second},
                         {"seconds", {{"total", to_seconds(clock_.now() - started_)}}},
                         {"frame_list", list}};
    if (!command_.report.empty()) write_text_file(command_.report, json_document(report));
  }

  void print_summary(const json& list, const FilmPictures& pictures, bool made) const {
    double least = std::numeric_limits<double>::infinity();
    double most = 0;
    for (const json& frame : list) {
      const bool denoised = frame.contains("denoised");
      const json rmse = frame.at(denoised ? "denoised" : "error").value("rmse", json());
      if (!rmse.is_number()) continue;
      least = std::min(least, rmse.get<double>());
      most = std::max(most, rmse.get<double>());
    }
    std::cout << "wrote " << (made ? command_.film : folder_.path().string()) << ": "
              << counted(frames_.count(), "frame") << " of " << pictures.width << " x "
              << pictures.height << " pixels, "
              << (most > 0 ? "error " + formatted("%.3g to %.3g", least, most) : "unknown error")
              << ", " << duration_text(to_seconds(clock_.now() - started_)) << "\n";
  }

  const FilmCommand& command_;
  const Time started_;
  SteadyClock clock_;
  FilmFrames frames_;
  const std::vector<std::string> files_;  ///< from which the frames are made
  const InputFiles inputs_;
  const std::string identity_;
  FilmFolder folder_;
  std::set<std::uint32_t> there_;  ///< frames of an earlier run
  bool noted_ = false;             ///< the notes of the readers are printed
  bool told_ = false;              ///< tell_of_other_film() has done its work
  std::optional<std::pair<std::uint32_t, std::uint32_t>> size_;
};

void check(const FilmCommand& command) {
  check_film_name(command.film);
  check_output_path(command.film);
  if (!command.report.empty()) check_output_path(command.report);
  if (same_file(command.report, command.film)) {
    throw InputError(command.report + ": film and report need different files");
  }
  if (command.course.scene == standard_input_argument) {
    throw InputError("-: a film reads its file several times: save the standard input as a file");
  }
  if (command.on_farm && command.threads) {
    throw InputError(
        "--threads has no effect with --farm, because its workers trace: leave out one of the two");
  }
  if (command.render.transparent(false)) {
    require(RenderMode::film, Feature::transparency, "--transparent");
  }
  (void)checked_inputs(command);
}

int film(const FilmCommand& command) {
  const Time started = SteadyClock().now();
  check(command);
  Film film(command, started);
  const DeferredInterrupts deferred;
  const int status = film.render();
  if (!film.is_complete()) {
    std::cerr << "parray: no " << printable(command.film, 4096)
              << ": frames are missing: remove the causes above, and run the same command again\n";
    return 1;
  }
  return std::max(status, film.finish());
}

void add_frames_to(Command& command, FilmCommand& options) {
  command.section(film_group);
  command
      .option(
          "--frames",
          [&options](const std::string& text) { options.course.frames = chosen_frames_from(text); },
          "Frames of the trajectory, of the camera path if the scene has one frame, or numbers "
          "that replace #### in the name: all, 0:100 or 0:100:5 (first, last, step). Default: all, "
          "but #### needs a range")
      .type_name("FIRST:LAST:STEP");
  add_real_number(command, "--turntable", {-36000, 36000}, options.course.turntable,
                  "Turn the camera around the scene by so many degrees over the film; 360 makes a "
                  "film that can be repeated")
      .type_name("DEG");
  add_camera_path(command, options.course.camera_path);
  add_whole_number(
      command, "--count", 1, limits::max_frames, options.course.count,
      "Number of frames, if the scene has only one (default: 100, or those of the camera path)");
  command
      .flag("--moving-noise", options.moving_noise,
            "Give each frame its own noise, like the grain of a film. By default all frames have "
            "the same seed, so what does not change hardly flickers")
      .special();
}

void add_output_to(Command& command, FilmCommand& options) {
  command.section(output_group);
  add_file(command, "-o,--output", options.film,
           "Film to write: .mp4, .webm or .gif. The pictures of its frames are in the folder "
           "beside it: run.frames for run.mp4. The same command continues an interrupted film")
      .type_name("FILM")
      .required();
  add_real_number(command, "--fps", {0.1, 240}, options.per_second,
                  "Frames per second (default: 25)");
  add_file(command, "--report", options.report,
           "Write a report as JSON: error, samples, seconds and hash of each frame")
      .type_name("FILE.json");
  command.flag(denoise_option, options.denoise,
               "Denoise each frame, and estimate its remaining RMSE");
  add_quiet(command, options.following.quiet);
}

void add_farm_to(Command& command, FilmCommand& options) {
  add_whole_number(
      command, "--threads", 1, most_threads, options.threads,
      "Number of threads that trace on this machine (default: all available processors)")
      .group(work_group);
  command.section(farm_group);
  const Option farm =
      command.flag("--farm", options.on_farm,
                   "Render the frames on the farm of --coordinator, as one series of jobs");
  add_priority(command, options.priority).needs(farm);
  options.farm.add_to(command, &farm);
}

}  // namespace

void add_film(CommandLine& line) {
  Command command = line.command(
      "film", "Make a film of a trajectory, or of a scene around which the camera moves");
  const auto options = std::make_shared<FilmCommand>();
  options->declared = command;
  add_scene(command, options->course.scene);
  add_frames_to(command, *options);
  options->render.add_to(command);
  options->render.aim_at(auto_scene_error);
  options->render.add_quality_to(command);
  add_output_to(command, *options);
  options->postprocessing.add_to(command, nullptr);
  options->labels.add_to(command, nullptr, options->render);
  add_farm_to(command, *options);
  command.example("parray film run.xyz -o run.mp4 --frames 0:20:5 --color-by element",
                  "every fifth frame of a trajectory, with one camera and the same colours");
  command.example("parray film scenes/particles/helix.pdb -o helix.mp4 --turntable 360 --count 50",
                  "a molecule that turns once");
  command.example("parray film scenes/glass.json -o glass.webm --camera-path path.json --fps 30",
                  "a flight through a scene");
  command.example("parray film run.xyz -o farm.mp4 --farm --coordinator tcp://farm:7400",
                  "renders the frames on the farm of this coordinator");
  command.runs([options] { return film(*options); });
}

}  // namespace parray::commands
