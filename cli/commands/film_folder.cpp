#include "cli/commands/film_folder.h"

#include <chrono>
#include <fstream>
#include <span>
#include <string_view>
#include <system_error>
#include <utility>

#include "cli/child_process/child_process.h"
#include "cli/output/picture/partial_file.h"
#include "cli/output/text.h"
#include "common/base/error.h"
#include "common/base/files.h"
#include "common/base/printable.h"
#include "common/base/sha256.h"
#include "common/base/text.h"
#include "common/process/stop_signal.h"

namespace parray::commands {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

std::string kind_of(const fs::path& film) { return lower_case(film.extension().string()); }

/// Returns a path for ffmpeg: it cannot begin like an option or a protocol, and % has no meaning.
std::string plain_path(const fs::path& path) {
  std::string text;
  for (const char letter : fs::absolute(path).string()) {
    text += letter == '%' ? "%%" : std::string(1, letter);
  }
  return text;
}

std::string last_line(const fs::path& file) {
  std::ifstream input(file);
  std::string last;
  for (std::string line; std::getline(input, line);) {
    if (!trimmed(line).empty()) last = line;
  }
  return printable(last, 500);
}

void add_file(const std::string& file, Sha256& hash) {
  std::ifstream input(file, std::ios::binary);
  if (!input) throw InputError(printable(file, 4096) + ": cannot be read: check the path");
  std::vector<char> block(std::size_t{1} << 20);
  while (input) {
    input.read(block.data(), std::ssize(block));
    const auto got = static_cast<std::size_t>(input.gcount());
    hash.add(std::as_bytes(std::span(block).first(got)));
    check_interrupted();
  }
}

/// Returns the report of a frame; null if there is none.
json report_in(const fs::path& file) {
  const auto text = read_file(file.string());
  return text ? json::parse(*text, nullptr, false) : json();
}

/// Returns what the report of a frame says about its film; an empty object if it says nothing.
json film_in(const fs::path& file) {
  const json report = report_in(file);
  const auto film = report.is_object() ? report.find("film") : report.end();
  const bool valid =
      film != report.end() && film->is_object() && film->value("identity", json()).is_string();
  return valid ? *film : json::object();
}

}  // namespace

FilmFolder::FilmFolder(const fs::path& film, std::string identity)
    : path_(fs::path(film).replace_extension(".frames")), identity_(std::move(identity)) {
  std::error_code problem;
  fs::create_directory(path_, problem);
  if (!fs::is_directory(path_)) {
    const bool in_the_way = fs::is_regular_file(path_);
    throw InputError(printable(path_.string(), 4096) +
                     ": the folder for the frames cannot be made" +
                     (problem ? " (" + problem.message() + ")" : "") +
                     (in_the_way ? ": remove the file of this name, or choose another name with -o"
                                 : ": choose another name with -o"));
  }
  check_output_path(picture(0));
}

fs::path FilmFolder::picture(std::uint32_t place) const { return path_ / film_picture(place); }

fs::path FilmFolder::report(std::uint32_t place) const {
  return picture(place).replace_extension(".json");
}

json FilmFolder::facts(std::uint32_t place, std::uint32_t frame) const {
  return {{"film", {{"identity", identity_}, {"place", place}, {"frame", frame}}}};
}

bool FilmFolder::has(std::uint32_t place) const {
  const json film = film_in(report(place));
  std::error_code ignored;
  return fs::is_regular_file(picture(place), ignored) && film.value("identity", "") == identity_ &&
         film.value("place", json()) == json(place);
}

bool FilmFolder::has_other_film() const {
  const std::string identity = film_in(report(0)).value("identity", "");
  return !identity.empty() && identity != identity_;
}

json FilmFolder::frame_list(std::uint32_t count) const {
  json list = json::array();
  for (std::uint32_t place = 0; place < count; ++place) {
    const json report = report_in(this->report(place));
    try {
      json entry = {{"frame", report.at("film").at("frame")}, {"picture", film_picture(place)}};
      for (const char* key :
           {"error", "samples", "samples_per_pixel", "stopped_by", "image_sha256"}) {
        entry[key] = report.value(key, json());
      }
      if (report.contains("denoised")) entry["denoised"] = report["denoised"];
      entry["seconds"] = report.at("seconds").value("render", json());
      for (const char* key : {"width", "height"}) (void)report.at(key).get<std::uint32_t>();
      list.push_back(std::move(entry));
    } catch (const json::exception&) {
      throw RunError(printable(this->report(place).string(), 4096) +
                     " is not the report of a frame: delete it, and run the same command again");
    }
  }
  return list;
}

std::string film_identity(const std::string& request, const std::vector<std::string>& files) {
  Sha256 hash;
  hash.add(std::as_bytes(std::span(request)));
  for (const std::string& file : files) add_file(file, hash);
  return hash.hex();
}

std::string film_picture(std::uint32_t number) {
  return formatted("frame-%06u.png", static_cast<unsigned>(number));
}

void check_film_name(const fs::path& film) {
  const std::string kind = kind_of(film);
  if (kind == ".mp4" || kind == ".webm" || kind == ".gif") return;
  throw InputError(printable(film.string(), 4096) +
                   ": unknown kind of film: use a name that ends in .mp4, .webm or .gif");
}

bool needs_padding(const FilmPictures& pictures, const fs::path& film) {
  return kind_of(film) != ".gif" && (pictures.width % 2 != 0 || pictures.height % 2 != 0);
}

std::vector<std::string> encoder_arguments(const FilmPictures& pictures, const fs::path& target) {
  std::vector<std::string> arguments;
  const auto add = [&arguments](const std::string& words) {
    for (const std::string_view word : words_of(words)) arguments.emplace_back(word);
  };
  add("-y -nostdin -loglevel error -framerate " + number_text(pictures.per_second));
  add("-start_number 0 -i");
  arguments.push_back(plain_path(pictures.folder) + "/frame-%06d.png");
  const std::string kind = kind_of(target);
  if (kind == ".gif") {
    add("-filter_complex split[a][b];[a]palettegen[p];[b][p]paletteuse");
  } else {
    const bool pads = needs_padding(pictures, target);
    add(std::string("-vf ") + (pads ? "pad=ceil(iw/2)*2:ceil(ih/2)*2," : "") +
        "scale=out_color_matrix=bt709:out_range=tv -pix_fmt yuv420p -colorspace bt709 "
        "-color_primaries bt709 -color_trc iec61966-2-1");
    add(kind == ".webm" ? "-c:v libvpx-vp9 -crf 20 -b:v 0"
                        : "-c:v libx264 -crf 17 -movflags +faststart");
  }
  add("-frames:v " + std::to_string(pictures.count));
  arguments.push_back(fs::absolute(target).string());
  return arguments;
}

std::optional<NoFilm> encode_film(const FilmPictures& pictures, const fs::path& film,
                                  const std::string& path) {
  const auto ffmpeg = find_program("ffmpeg", path);
  if (!ffmpeg) return NoFilm{"ffmpeg is missing (apt-get install ffmpeg)", true};
  PartialFile partial(film);
  std::vector<std::string> arguments = encoder_arguments(pictures, partial.path());
  arguments.insert(arguments.begin(), ffmpeg->string());
  const fs::path log = pictures.folder / "ffmpeg.log";
  const ChildEnd end = run_child(arguments, {}, log, std::chrono::hours(24));
  const bool made = end.status == 0 && !end.timed_out && fs::exists(partial.path());
  if (!made) {
    const std::string line = last_line(log);
    return NoFilm{"ffmpeg failed: " + (line.empty() ? "it wrote no message" : line)};
  }
  partial.commit();
  std::error_code ignored;  // the film exists
  fs::remove(log, ignored);
  return std::nullopt;
}

}  // namespace parray::commands
