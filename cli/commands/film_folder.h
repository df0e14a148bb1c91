#pragma once

#include <cstdint>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "common/rooms.h"

/// The files of a film: the pictures of its frames, and the film that ffmpeg makes of them.
namespace parray::commands {

/// The folder beside a film, x.frames for x.mp4: a picture and a report for each frame. An
/// interrupted film continues with the frames that are there. `place`: place of a frame in the
/// film, from 0. `frame`: its number, FilmFrames::numbers()[place].
class FilmFolder {
 public:
  /// Makes the folder, if it does not exist. `identity`: the film_identity() of this film; the
  /// reports store it. Throws InputError if the folder cannot be made or written.
  FilmFolder(const std::filesystem::path& film, std::string identity);

  [[nodiscard]] const std::filesystem::path& path() const { return path_; }
  /// Return the paths of a frame's files.
  [[nodiscard]] std::filesystem::path picture(std::uint32_t place) const;
  [[nodiscard]] std::filesystem::path report(std::uint32_t place) const;
  /// Returns the members that the caller adds to a frame's report, so that has() recognises it.
  [[nodiscard]] nlohmann::json facts(std::uint32_t place, std::uint32_t frame) const;

  /// Returns whether the picture of a frame is there, and its report has this film's identity.
  [[nodiscard]] bool has(std::uint32_t place) const;
  /// Returns whether the report of the first frame is that of a film with another identity.
  [[nodiscard]] bool has_other_film() const;
  /// Returns the member "frame_list" of the film's report, from the reports of `count` frames:
  /// frame, picture, error, samples, samples_per_pixel, stopped_by, denoised, seconds (of
  /// rendering) and image_sha256 of each. Throws RunError if the report of a frame is missing or
  /// incomplete.
  [[nodiscard]] nlohmann::json frame_list(std::uint32_t count) const;

 private:
  const std::filesystem::path path_;
  const std::string identity_;
};

/// Returns the SHA-256 of `request`, a text with all options that determine the frames, and of the
/// contents of `files`. Throws InputError if a file cannot be read, and Interrupted.
std::string film_identity(const std::string& request, const std::vector<std::string>& files);

/// Numbered pictures that become a film.
struct FilmPictures {
  std::filesystem::path folder;
  std::uint32_t count = 0;  ///< pictures 0 to count - 1, named by film_picture()
  std::uint32_t width = 0;  ///< of each picture, in pixels
  std::uint32_t height = 0;
  double per_second = 25;  ///< pictures per second of film
};

/// Returns the name of a picture in its folder: "frame-000007.png".
std::string film_picture(std::uint32_t number);

/// Throws InputError unless the name ends in .mp4, .webm or .gif.
void check_film_name(const std::filesystem::path& film);

/// Returns whether the film's format needs an even width and height (all but GIF do), and the width
/// or the height of the pictures is odd.
bool needs_padding(const FilmPictures& pictures, const std::filesystem::path& film);

/// Returns the arguments of ffmpeg, without the program, that make the file `target` of the
/// pictures. Except in a GIF, colours have the range and the matrix of Rec. ITU-R BT.709, and odd
/// sizes get one more row or column.
std::vector<std::string> encoder_arguments(const FilmPictures& pictures,
                                           const std::filesystem::path& target);

/// Why there is no film.
struct NoFilm {
  std::string why;
  bool missing = false;  ///< ffmpeg was not found
};
/// Makes the film with ffmpeg, which it looks for in the directories of `path` ("/usr/bin:/bin").
/// The file `film` appears when it is complete. Returns nothing if the film is written, otherwise
/// why not. Throws Interrupted, and RunError if ffmpeg cannot be started or the finished file
/// cannot be renamed.
std::optional<NoFilm> encode_film(const FilmPictures& pictures, const std::filesystem::path& film,
                                  const std::string& path);

}  // namespace parray::commands
