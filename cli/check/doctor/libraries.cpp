#include "cli/check/doctor/libraries.h"

#include <spdlog/version.h>
#include <sqlite3.h>

#include <limits>
#include <string>
#include <tuple>
#include <zmq.hpp>

#include "cli/output/picture/image_file.h"
#include "cli/output/picture/srgb.h"
#include "common/base/sha256.h"
#include "coordinator/store/disk_store.h"

namespace parray::doctor {
namespace {

std::string dotted(int major, int minor, int patch) {
  return std::to_string(major) + "." + std::to_string(minor) + "." + std::to_string(patch);
}

std::string zmq_version_text() {
  const auto [major, minor, patch] = zmq::version();
  return dotted(major, minor, patch);
}

/// Returns a picture with values that a wrong writer would change, by rounding to half precision or
/// by clamping.
Image extreme_image() {
  Image image{64, 32, {}};
  const std::size_t values = 3UL * image.width * image.height;
  image.rgb = {0.0F,
               1.0F,
               0x1.000002p0F,
               1e-3F,
               std::numeric_limits<float>::denorm_min(),
               std::numeric_limits<float>::max(),
               65504.5F,
               1.0F / 3};
  for (std::uint32_t i = 0; image.rgb.size() < values; ++i) {
    image.rgb.push_back(static_cast<float>(i * 2654435761U) * 0x1p-30F);
  }
  return image;
}

Image byte_image() {
  Image image{16, 16, {}};
  for (int i = 0; i < 256 * 3; ++i) {
    image.rgb.push_back(static_cast<float>(srgb_decode(static_cast<double>(i % 256) / 255)));
  }
  return image;
}

/// Writes a picture, reads it again, and returns whether all bits are the same.
bool reads_back(const std::filesystem::path& file, const Image& image) {
  write_image(file, image, {{"Software", "ParRay"}});
  const Image found = read_image(file).image;
  return found.width == image.width && found.height == image.height &&
         image_sha256(found) == image_sha256(image);
}

}  // namespace

CheckResult check_libraries() {
  const nlohmann::json versions = {
      {"OpenEXR", exr_library_version()},
      {"OpenImageIO", image_library_version()},
      {"ZeroMQ", zmq_version_text()},
      {"SQLite", sqlite3_libversion()},
      {"nlohmann-json", dotted(NLOHMANN_JSON_VERSION_MAJOR, NLOHMANN_JSON_VERSION_MINOR,
                               NLOHMANN_JSON_VERSION_PATCH)},
      {"spdlog", dotted(SPDLOG_VER_MAJOR, SPDLOG_VER_MINOR, SPDLOG_VER_PATCH)},
      {"OpenMP", std::to_string(_OPENMP)}};  // the year and month of its specification
  std::string text;
  for (const auto& [name, version] : versions.items()) {
    text += (text.empty() ? "" : ", ") + name + " " + version.get<std::string>();
  }
  CheckResult found = std::get<0>(zmq::version()) == ZMQ_VERSION_MAJOR
                          ? passed(text)
                          : failed(text + "; built for ZeroMQ " + std::to_string(ZMQ_VERSION_MAJOR),
                                   "build ParRay again with the libraries of this machine");
  found.facts = versions;
  return found;
}

CheckResult check_pictures(const std::filesystem::path& directory) {
  const bool exr = reads_back(directory / "trial.exr", extreme_image());
  const bool png = reads_back(directory / "trial.png", byte_image());
  if (exr && png) return passed("EXR and PNG files contain the values that were written");
  return failed(std::string(exr ? "" : "EXR") + (exr || png ? "" : " and ") + (png ? "" : "PNG") +
                    " files contain other values than were written",
                std::string("reinstall ") + (exr ? "" : "OpenEXR (Debian: libopenexr-3-1-30)") +
                    (exr || png ? "" : " and ") + (png ? "" : "libpng (Debian: libpng16-16)"));
}

CheckResult check_state(const std::filesystem::path& directory) {
  const std::filesystem::path place = directory / "state";
  const std::string bytes(100'000, 'x');
  const std::string digest = sha256_hex(std::as_bytes(std::span(bytes)));
  {
    DiskStore store(place);
    store.put_scene(digest, bytes);
    JobRecord job;  // the store may drop a scene that no unfinished job uses
    job.id = 1;
    job.token = "doctor";
    job.name = "doctor";
    job.scene = digest;
    store.put_job(job);
    store.commit();
  }
  DiskStore store(place);
  return store.scene(digest) == bytes
             ? passed("committed data is there after closing and opening")
             : failed("committed data is missing after closing and opening",
                      "if the state of a coordinator is on the file system of TMPDIR, move it to a "
                      "local disk: SQLite needs working locks and syncs");
}

}  // namespace parray::doctor
