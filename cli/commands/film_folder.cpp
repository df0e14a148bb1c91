#include "cli/commands/film_folder.h"

#include <fstream>
#include <span>
#include <system_error>
#include <utility>

#include "cli/commands/film_encoder.h"
#include "cli/output/picture/partial_file.h"
#include "common/base/error.h"
#include "common/base/files.h"
#include "common/base/printable.h"
#include "common/base/sha256.h"
#include "common/process/stop_signal.h"

namespace parray::commands {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

/// Adds the contents of a file.
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

}  // namespace parray::commands
