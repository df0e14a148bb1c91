// parray-http-child: reads uploaded scenes and writes picture files for the coordinator's HTTP
// service. Memory and processor time are limited. The coordinator makes a directory for it, the
// parent of the current one, and the process can open no files outside. Only the coordinator starts
// this program.
#include <sys/prctl.h>
#include <sys/resource.h>

#include <csignal>
#include <filesystem>
#include <fstream>
#include <iostream>
#include <iterator>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <string_view>
#include <vector>

#include "cli/commands/options.h"
#include "cli/commands/prepare.h"
#include "cli/output/error_map.h"
#include "cli/output/picture/image_file.h"
#include "cli/output/picture/thumbnail.h"
#include "cli/scene_sandbox/confinement.h"
#include "common/base/error.h"
#include "common/base/files.h"
#include "common/image/picture_bytes.h"
#include "common/process/run_main.h"
#include "common/scene/settings.h"

namespace {

using namespace parray::scene_sandbox;
using nlohmann::json;

// The name is parray, because users read the messages as those of the command line.
constexpr Program as_parray = {"parray", "Read scenes and write pictures for the HTTP service",
                               PARRAY_VERSION};

struct Arguments {
  std::size_t memory = 0;
  std::size_t seconds = 0;
  std::string scene;
  std::string name;
  RenderOptions render;
  std::uint32_t priority = 50;
  std::uint32_t max_failures = 0;
  bool progressive = false;
  std::string wanted;
  std::size_t width = 0;
  std::size_t height = 0;
  std::size_t thumbnail_width = 0;  ///< 0: the whole picture
};

void limit(decltype(RLIMIT_AS) what, rlim_t value) {
  const rlimit wanted{value, value};
  if (setrlimit(what, &wanted) != 0) throw RunError("a limit of this process cannot be set");
}

Enclosure enclosure_of(std::uint64_t file_bytes) {
  return {std::filesystem::current_path().parent_path(), file_bytes};
}

/// Limits memory and processor time, ends this process with its parent, and confines it, in case a
/// damaged file takes it over. `file_bytes`: size of the largest file that it may write.
void confine(const Arguments& a, std::uint64_t file_bytes) {
  prctl(PR_SET_PDEATHSIG, SIGKILL);
  prctl(PR_SET_DUMPABLE, 0);
  limit(RLIMIT_CORE, 0);
  limit(RLIMIT_CPU, a.seconds);
#ifndef PARRAY_SANITIZED  // the shadow memory of sanitizers needs a huge address space
  limit(RLIMIT_AS, a.memory);
  enclose_process(enclosure_of(file_bytes));
#else
  static_cast<void>(file_bytes);
#endif
}

void keep_file(const std::filesystem::path& file, std::string_view bytes) {
  if (!write_file(file, bytes)) {
    throw RunError("writing " + file.filename().string() + " failed: is the disk full?");
  }
}

std::string bytes_of(const std::filesystem::path& file) {
  std::optional<std::string> bytes = read_file(file);
  if (!bytes) throw RunError("reading " + file.string() + " failed");
  return *std::move(bytes);
}

/// Reads the scene in the current directory, and writes the frames of its message `submit` to
/// ../control and ../bulk.
int submit(const Arguments& a) {
  confine(a, a.memory);
  Submission submission =
      load_submission(RenderMode::http, a.scene, a.render, a.priority).submission;
  submission.max_failures = a.max_failures;
  submission.settings->progressive = a.progressive;
  if (!a.name.empty()) submission.name = a.name;
  msg::Submit message = submit_message(std::move(submission));
  message.token = "to be replaced";
  const Frames frames = encode(message);
  keep_file("../control", frames.at(0).view());
  keep_file("../bulk", frames.at(1).view());
  return 0;
}

/// Writes the file `wanted` from `pixels` and `report` in the current directory.
int picture(const Arguments& a) {
  constexpr std::uint64_t most_of_head = std::uint64_t{1} << 20;
  constexpr std::uint64_t most_of_pixel = 128;
  confine(a, most_of_head + most_of_pixel * a.width * a.height);
  Picture picture;
  picture.report = json::parse(bytes_of("report"));
  PictureParts parts = picture_from_bytes(static_cast<std::uint32_t>(a.width),
                                          static_cast<std::uint32_t>(a.height), bytes_of("pixels"));
  picture.image = std::move(parts.image);
  picture.statistics = std::move(parts.statistics);
  if (a.thumbnail_width > 0) {
    write_image(a.wanted, thumbnail(picture.image, static_cast<std::uint32_t>(a.thumbnail_width)),
                {{"Software", "ParRay " PARRAY_VERSION}});
  } else if (a.wanted == "error.png") {
    write_error_map(a.wanted, picture);
  } else if (a.wanted == "error.f32") {
    const std::vector<float> widths = half_widths_of(picture.statistics, a.width * a.height);
    keep_file(a.wanted,
              {reinterpret_cast<const char*>(widths.data()), widths.size() * sizeof(float)});
  } else if (picture.report.value("partial", false)) {
    write_image(a.wanted, picture.image,
                {{"Software", "ParRay " PARRAY_VERSION}, {"parray:partial", std::uint64_t{1}}});
  } else {
    if (can_hold_channels(a.wanted)) add_sample_counts(picture);
    write_picture(a.wanted, picture);
  }
  return 0;
}

/// Prints on stderr, in one line, the forbidden actions that succeed. Prints nothing if all are
/// refused.
int confinement(const Arguments& a) {
  constexpr std::uint64_t small = 1000;
  confine(a, small);
  std::string text;
  for (const std::string& way : ways_out(enclosure_of(small), a.wanted)) {
    text += (text.empty() ? "" : ", ") + way;
  }
  if (!text.empty()) std::cerr << text << '\n';
  return 0;
}

void declare_submit(CommandLine& line, Arguments& a, Action& chosen) {
  Command command = line.command("submit", "Read a scene");
  add_scene(command, a.scene);
  command.option("--name", a.name, "Name of the scene, for people");
  add_whole_number(
      command, "--priority", 0, 100,
      [&a](std::uint64_t value) { a.priority = static_cast<std::uint32_t>(value); }, "");
  add_whole_number(
      command, "--max-failures", 1, 1000,
      [&a](std::uint64_t value) { a.max_failures = static_cast<std::uint32_t>(value); }, "");
  command.flag("--progressive", a.progressive, "");
  a.render.add_to(command);
  command.on_chosen([&] { chosen = [&a] { return submit(a); }; });
}

void declare_picture(CommandLine& line, Arguments& a, Action& chosen) {
  Command command = line.command("picture", "Write a picture file");
  command.option("FILE", a.wanted, "").required();
  command.number("WIDTH", a.width, 1, std::size_t{1} << 32, "").required();
  command.number("HEIGHT", a.height, 1, std::size_t{1} << 32, "").required();
  command.number("--thumbnail-width", a.thumbnail_width, 1, 1024, "Write a smaller copy");
  command.on_chosen([&] { chosen = [&a] { return picture(a); }; });
}

void declare_confinement(CommandLine& line, Arguments& a, Action& chosen) {
  Command command = line.command("confinement", "Try forbidden actions");
  command.option("FILE", a.wanted, "File that the process must not be able to read").required();
  command.on_chosen([&] { chosen = [&a] { return confinement(a); }; });
}

}  // namespace

int main(int argc, char** argv) {
  Arguments arguments;
  Action chosen;
  return run_main(as_parray, argc, argv, [&](CommandLine& line) -> Action {
    line.number("--memory", arguments.memory, 0, std::size_t{1} << 50, "Bytes").required();
    line.number("--seconds", arguments.seconds, 1, 1000000, "Processor time").required();
    declare_submit(line, arguments, chosen);
    declare_picture(line, arguments, chosen);
    declare_confinement(line, arguments, chosen);
    return [&chosen] { return chosen ? chosen() : 2; };
  });
}
