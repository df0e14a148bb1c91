#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "common/rooms.h"

namespace parray::commands {

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
