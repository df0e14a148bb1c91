// parray-http-child: what the coordinator's HTTP interface has done by others. It reads what
// strangers send, under limits of memory and processor time, and makes picture files; both in a
// directory that the coordinator has made, the current one's parent, beyond which it can open
// nothing. People do not start it.
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
#include "cli/scene_sandbox/confinement.h"
#include "common/base/error.h"
#include "common/base/files.h"
#include "common/image/picture_bytes.h"
#include "common/process/run_main.h"
#include "common/scene/settings.h"

namespace {

using namespace parray::scene_sandbox;
using nlohmann::json;

// Messages are those of the command line.
constexpr Program as_parray = {"parray", "What the coordinator's HTTP interface has done by others",
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
};

void limit(decltype(RLIMIT_AS) what, rlim_t value) {
  const rlimit wanted{value, value};
  if (setrlimit(what, &wanted) != 0) throw RunError("a limit of this process cannot be set");
}

Enclosure enclosure_of(std::uint64_t file_bytes) {
  return {std::filesystem::current_path().parent_path(), file_bytes};
}

/// A scene can neither eat the machine nor outlive who has asked for it, and whoever takes this
/// process over by a damaged file gets nothing else. `file_bytes`: of the largest file that it may
/// write.
void confine(const Arguments& a, std::uint64_t file_bytes) {
  prctl(PR_SET_PDEATHSIG, SIGKILL);
  prctl(PR_SET_DUMPABLE, 0);
  limit(RLIMIT_CORE, 0);
  limit(RLIMIT_CPU, a.seconds);
#ifndef PARRAY_SANITIZED  // whose shadow takes more address space than any machine has memory
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

/// Of the scene in the current directory: ../control and ../bulk, the frames of its `submit`.
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

/// Of `pixels` and `report` in the current directory: the file `wanted`.
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
  if (picture.report.value("partial", false)) {
    write_image(a.wanted, picture.image,
                {{"Software", "ParRay " PARRAY_VERSION}, {"parray:partial", std::uint64_t{1}}});
  } else if (a.wanted == "error.png") {
    write_error_map(a.wanted, picture);
  } else if (a.wanted == "error.f32") {
    const std::vector<float> widths = half_widths_of(picture.statistics, a.width * a.height);
    keep_file(a.wanted,
              {reinterpret_cast<const char*>(widths.data()), widths.size() * sizeof(float)});
  } else {
    if (can_hold_channels(a.wanted)) add_sample_counts(picture);
    write_picture(a.wanted, picture);
  }
  return 0;
}

/// Says on stderr what it could do beyond its directory, as one line; nothing where all is refused.
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
  command.option("--name", a.name, "Of the scene, for people");
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
  Command command = line.command("picture", "Make a picture's file");
  command.option("FILE", a.wanted, "").required();
  command.number("WIDTH", a.width, 1, std::size_t{1} << 32, "").required();
  command.number("HEIGHT", a.height, 1, std::size_t{1} << 32, "").required();
  command.on_chosen([&] { chosen = [&a] { return picture(a); }; });
}

void declare_confinement(CommandLine& line, Arguments& a, Action& chosen) {
  Command command = line.command("confinement", "Try what this process can do");
  command.option("FILE", a.wanted, "That it must not read").required();
  command.on_chosen([&] { chosen = [&a] { return confinement(a); }; });
}

}  // namespace

int main(int argc, char** argv) {
  Arguments arguments;
  Action chosen;
  return run_main(as_parray, argc, argv, [&](CommandLine& line) -> Action {
    line.number("--memory", arguments.memory, 0, std::size_t{1} << 50, "Bytes").required();
    line.number("--seconds", arguments.seconds, 1, 1000000, "Of processor time").required();
    declare_submit(line, arguments, chosen);
    declare_picture(line, arguments, chosen);
    declare_confinement(line, arguments, chosen);
    return [&chosen] { return chosen ? chosen() : 2; };
  });
}
