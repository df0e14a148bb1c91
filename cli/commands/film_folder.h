#pragma once

#include <cstdint>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "common/rooms.h"

namespace parray::commands {

/// The folder beside a film, x.frames for x.mp4: a picture and a report for each frame. An
/// interrupted film continues with the frames that are there.
class FilmFolder {
 public:
  /// Makes the folder. `identity`: a text that is equal for equal frames; it is stored in the
  /// reports. Throws InputError if the folder cannot be made or written.
  FilmFolder(const std::filesystem::path& film, std::string identity);

  [[nodiscard]] const std::filesystem::path& path() const { return path_; }
  [[nodiscard]] std::filesystem::path picture(std::uint32_t place) const;
  [[nodiscard]] std::filesystem::path report(std::uint32_t place) const;
  /// Returns the members of a frame's report by which has() recognises it.
  [[nodiscard]] nlohmann::json facts(std::uint32_t place, std::uint32_t frame) const;

  /// Returns whether the picture of a frame is there, made by a film of the same identity.
  [[nodiscard]] bool has(std::uint32_t place) const;
  /// Returns whether the report of the first frame is that of a film with another identity.
  [[nodiscard]] bool has_other_film() const;
  /// Returns what the report of the film says about the frames: number, picture, error, samples,
  /// samples_per_pixel, stopped_by, denoised, seconds and image_sha256 of each. Throws RunError if
  /// the report of a frame is missing or incomplete.
  [[nodiscard]] nlohmann::json frame_list(std::uint32_t count) const;

 private:
  const std::filesystem::path path_;
  const std::string identity_;
};

/// Returns the SHA-256 of a request and of the contents of files. Throws InputError if a file
/// cannot be read.
std::string film_identity(const std::string& request, const std::vector<std::string>& files);

}  // namespace parray::commands
