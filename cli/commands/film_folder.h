#pragma once

#include <cstdint>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "common/rooms.h"

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

}  // namespace parray::commands
