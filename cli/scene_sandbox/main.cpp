// parray-http-child: reads uploaded scenes and writes picture files for the coordinator's HTTP
// service. Memory and processor time are limited. The process can open files only in the parent of
// its current directory (confinement.h). Only the coordinator starts this program.
#include <iostream>
#include <string>

#include "cli/commands/options.h"
#include "cli/scene_sandbox/confinement.h"
#include "cli/scene_sandbox/forecast.h"
#include "cli/scene_sandbox/limits.h"
#include "cli/scene_sandbox/picture_writer.h"
#include "cli/scene_sandbox/upload_jobs.h"
#include "common/process/run_main.h"

namespace {

using namespace parray::scene_sandbox;

// The name is parray, because users read the messages as those of the command line.
constexpr Program as_parray = {"parray", "Read scenes and write pictures for the HTTP service",
                               PARRAY_VERSION};

struct Arguments {
  ChildResources resources;
  UploadRequest upload;
  PictureRequest picture;
  std::size_t first = 0;
  std::size_t threads = 0;
  std::string foreign;
};

/// Prints on stderr, in one line, the forbidden actions that succeed. Prints nothing if all are
/// refused.
int confinement(const Arguments& a) {
  constexpr std::uint64_t small = 1000;
  confine(a.resources, small);
  std::string text;
  for (const std::string& way : ways_out(enclosure_of(small), a.foreign)) {
    text += (text.empty() ? "" : ", ") + way;
  }
  if (!text.empty()) std::cerr << text << '\n';
  return 0;
}

void declare_submit(CommandLine& line, Arguments& a, Action& chosen) {
  Command command = line.command("submit", "Read a scene");
  add_scene(command, a.upload.scene);
  add_upload_options(command, a.upload);
  command.on_chosen([&] {
    chosen = [&a] {
      write_upload_jobs(a.upload, a.first, a.resources);
      return 0;
    };
  });
}

void declare_plan(CommandLine& line, Arguments& a, UploadRequest& upload, Action& chosen) {
  Command command = line.command("plan", "Forecast a scene");
  add_scene(command, upload.scene);
  add_upload_options(command, upload);
  command.on_chosen([&] {
    chosen = [&a, &upload] {
      write_forecast(upload, a.threads, a.resources);
      return 0;
    };
  });
}

void declare_picture(CommandLine& line, Arguments& a, Action& chosen) {
  Command command = line.command("picture", "Write a picture file");
  command.option("FILE", a.picture.wanted, "").required();
  command.number("WIDTH", a.picture.width, 1, std::size_t{1} << 32, "").required();
  command.number("HEIGHT", a.picture.height, 1, std::size_t{1} << 32, "").required();
  command.number("--thumbnail-width", a.picture.thumbnail_width, 1, 1024, "Write a smaller copy");
  command.flag("--denoise", a.picture.denoise, "Denoise the picture first");
  command.flag("--draw", a.picture.draw, "Draw labels and outlines");
  command.on_chosen([&] {
    chosen = [&a] {
      write_picture_file(a.picture, a.resources);
      return 0;
    };
  });
}

void declare_confinement(CommandLine& line, Arguments& a, Action& chosen) {
  Command command = line.command("confinement", "Try forbidden actions");
  command.option("FILE", a.foreign, "File that the process must not be able to read").required();
  command.on_chosen([&] { chosen = [&a] { return confinement(a); }; });
}

}  // namespace

int main(int argc, char** argv) {
  Arguments arguments;
  UploadRequest planned;  // a command line has options of its own
  Action chosen;
  return run_main(as_parray, argc, argv, [&](CommandLine& line) -> Action {
    line.number("--memory", arguments.resources.memory, 0, std::size_t{1} << 50, "Bytes")
        .required();
    line.number("--seconds", arguments.resources.seconds, 1, 1000000, "Processor time").required();
    line.number("--first", arguments.first, 0, std::size_t{1} << 32, "Place of the first frame");
    line.number("--threads", arguments.threads, 0, std::size_t{1} << 32, "Threads of the farm");
    declare_submit(line, arguments, chosen);
    declare_plan(line, arguments, planned, chosen);
    declare_picture(line, arguments, chosen);
    declare_confinement(line, arguments, chosen);
    return [&chosen] { return chosen ? chosen() : 2; };
  });
}
