// parray-http-child: reads uploaded scenes and writes picture files for the coordinator's HTTP
// service. Memory and processor time are limited. The process can open files only in the parent of
// its current directory (confinement.h). Only the coordinator starts this program.
#include <functional>
#include <iostream>
#include <string>
#include <utility>

#include "cli/commands/options.h"
#include "cli/scene_sandbox/confinement.h"
#include "cli/scene_sandbox/picture_writer.h"
#include "cli/scene_sandbox/upload_jobs.h"
#include "common/base/text.h"
#include "common/process/run_main.h"

namespace {

using namespace parray::scene_sandbox;

// The name is parray, because users read the messages as those of the command line.
constexpr Program as_parray = {"parray", "Read scenes and write pictures for the HTTP service",
                               PARRAY_VERSION};

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
void does(Command& command, Action& chosen, std::function<void()> work) {
  command.on_chosen([&chosen, work = std::move(work)] {
    chosen = [work] {
      work();
      return 0;
    };
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
  Action chosen;
  return run_main(as_parray, argc, argv, [&](CommandLine& line) -> Action {
    line.number("--memory", a.resources.memory, 0, std::size_t{1} << 50, "Bytes").required();
    line.number("--seconds", a.resources.seconds, 1, 1000000, "Processor time").required();
    line.number("--first", a.first, 0, std::size_t{1} << 32, "Place of the first frame");
    line.number("--threads", a.threads, 0, std::size_t{1} << 32, "Threads of the farm");
    Command submit = upload_command(line, "submit", "Read a scene", a.upload);
    does(submit, chosen, [&] { write_upload_jobs(a.upload, a.first, a.resources); });
    Command plan = upload_command(line, "plan", "Forecast a scene", a.planned);
    does(plan, chosen, [&] { write_forecast(a.planned, a.threads, a.resources); });
    Command picture = picture_command(line, a.picture);
    does(picture, chosen, [&] { write_picture_file(a.picture, a.resources); });
    Command attempt = line.command("confinement", "Try forbidden actions");
    attempt.option("FILE", a.foreign, "File that the process must not be able to read").required();
    does(attempt, chosen, [&] { confinement(a); });
    return [&chosen] { return chosen ? chosen() : 2; };
  });
}
