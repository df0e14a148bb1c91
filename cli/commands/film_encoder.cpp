#include "cli/commands/film_encoder.h"

#include <chrono>
#include <fstream>
#include <system_error>

#include "cli/child_process/child_process.h"
#include "cli/output/picture/partial_file.h"
#include "cli/output/text.h"
#include "common/base/error.h"
#include "common/base/printable.h"
#include "common/base/text.h"

namespace parray::commands {
namespace {

namespace fs = std::filesystem;

std::string kind_of(const fs::path& film) { return lower_case(film.extension().string()); }

/// Returns a path for ffmpeg: it cannot begin like an option or a protocol, and % has no meaning.
std::string plain_path(const fs::path& path) {
  std::string text;
  for (const char letter : fs::absolute(path).string()) {
    text += letter == '%' ? "%%" : std::string(1, letter);
  }
  return text;
}

/// Returns the filters and settings of a format. `padding`: a filter that makes sizes even.
std::vector<std::string> format_arguments(const std::string& kind, const std::string& padding) {
  if (kind == ".gif") return {"-filter_complex", "split[a][b];[a]palettegen[p];[b][p]paletteuse"};
  std::vector<std::string> arguments{"-vf",
                                     padding + "scale=out_color_matrix=bt709:out_range=tv",
                                     "-pix_fmt",
                                     "yuv420p",
                                     "-colorspace",
                                     "bt709",
                                     "-color_primaries",
                                     "bt709",
                                     "-color_trc",
                                     "iec61966-2-1"};
  const std::vector<std::string> codec =
      kind == ".webm"
          ? std::vector<std::string>{"-c:v", "libvpx-vp9", "-crf", "20", "-b:v", "0"}
          : std::vector<std::string>{"-c:v", "libx264", "-crf", "17", "-movflags", "+faststart"};
  arguments.insert(arguments.end(), codec.begin(), codec.end());
  return arguments;
}

std::string last_line(const fs::path& file) {
  std::ifstream input(file);
  std::string last;
  for (std::string line; std::getline(input, line);) {
    if (!trimmed(line).empty()) last = line;
  }
  return printable(last, 500);
}

}  // namespace

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
  std::vector<std::string> arguments{"-y",
                                     "-nostdin",
                                     "-loglevel",
                                     "error",
                                     "-framerate",
                                     number_text(pictures.per_second),
                                     "-start_number",
                                     "0",
                                     "-i",
                                     plain_path(pictures.folder) + "/frame-%06d.png"};
  const std::string padding =
      needs_padding(pictures, target) ? "pad=ceil(iw/2)*2:ceil(ih/2)*2," : "";
  for (std::string& argument : format_arguments(kind_of(target), padding)) {
    arguments.push_back(std::move(argument));
  }
  arguments.insert(arguments.end(), {"-frames:v", std::to_string(pictures.count)});
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
