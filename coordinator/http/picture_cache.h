#pragma once

#include <array>
#include <atomic>
#include <cstdint>
#include <filesystem>
#include <map>
#include <memory>
#include <mutex>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>

#include "coordinator/http/budget.h"
#include "coordinator/http/child.h"
#include "coordinator/http/file_body.h"
#include "coordinator/http/loop_client.h"
#include "coordinator/http/places.h"
#include "coordinator/store/job_record.h"

namespace parray::http {

/// Makes and caches files of pictures, including those of unfinished jobs. The loop delivers the
/// data, and a child process makes the file, which all clients share. A file of an unfinished
/// job is renewed at most once per second, and in at most 5 % of the time. The pictures of a done
/// job are denoised, and the PNG file gets labels, if the job's options say so. Thumbnails have no
/// labels. Callable from any thread.
class PictureCache {
 public:
  /// Content of a file. Numbers per pixel are little-endian, the top row first.
  enum class Kind : std::uint8_t {
    png,             ///< the picture as PNG
    exr,             ///< the picture as OpenEXR
    pixels,          ///< the picture as float32 RGB, linear
    error_png,       ///< the error map with a legend, as PNG
    error_pixels,    ///< the largest half-width of each pixel as float32; -1: unknown
    cost,            ///< thread-seconds per pixel as float32: WorkMap::seconds
    worker_numbers,  ///< the worker of each pixel as u32: WorkMap::tracer
    worker_names     ///< WorkMap::workers as JSON
  };

  /// `directory`: for files of child processes and cached files. `memory`: limits the memory of
  /// pictures that are being made. `disk`: limit of the cached files in bytes. All references must
  /// outlive this object, and it must outlive all files that get() returns: they give back bytes.
  PictureCache(LoopClient& loop, const ChildRunner& runner, Budget& memory, std::uint64_t disk,
               std::filesystem::path directory)
      : loop_(loop),
        runner_(runner),
        memory_(memory),
        disk_(disk),
        directory_(std::move(directory)) {}

  /// Makes all requests fail that wait for a child process.
  void stop() { places_.stop(); }

  /// A file with its properties. A thumbnail is in memory: there are many, and each open file takes
  /// a descriptor.
  struct File {
    std::shared_ptr<const FileBody> file;            ///< null for a thumbnail
    std::shared_ptr<const std::string> thumbnail{};  ///< null for other files
    std::string etag;
    std::uint32_t width = 0;   ///< of the whole picture, in pixels
    std::uint32_t height = 0;  ///< of the whole picture, in pixels
    /// Samples of all pixels together. Nothing for `cost` and the workers' files.
    std::optional<std::uint64_t> samples{};
    bool partial = false;  ///< the job is not done
  };
  /// Returns the cached file, or makes it. `owner`: the name under which the request waits for its
  /// turn (owner_of()). `thumbnail_width`: for `png`, the width in pixels of a smaller copy, if the
  /// picture is wider; 0: the whole picture. Throws Problem, for example if the job has no samples.
  /// Throws RunError if making the file fails.
  File get(const Sender& sender, const std::string& owner, JobId job, Kind kind,
           std::uint32_t thumbnail_width = 0);

 private:
  /// What a file shows, and the width of a thumbnail or 0.
  struct Key {
    JobId job = 0;
    Kind kind{};
    std::uint32_t thumbnail_width = 0;
    auto operator<=>(const Key&) const = default;
  };
  struct Entry {
    std::mutex mutex;  ///< guards the members down to `cost`
    File picture;
    std::string version;  ///< of the job, see version_of()
    Time made_at{};
    Time cost{};
    std::atomic<std::size_t> size = 0;  ///< bytes of the file
    Time used_at{};                     ///< guarded by PictureCache::mutex_
  };
  /// What happens to a picture before its file is written.
  struct Steps {
    bool denoise = false;
    bool draw = false;  ///< labels, outlines, background

    [[nodiscard]] bool any() const { return denoise || draw; }
  };
  static Steps steps_of(const nlohmann::json& job, const Key& key);
  static std::uint64_t memory_of(const nlohmann::json& job, Kind kind, Steps steps);
  std::shared_ptr<Entry> entry_of(const Key& key);
  void drop_old(bool thumbnails, std::size_t most_entries, std::size_t most_bytes);
  File make(const Sender& sender, const Key& key, Steps steps);
  File make_map(const Sender& sender, JobId job, Kind kind);
  std::shared_ptr<const FileBody> keep(const std::filesystem::path& file);
  std::shared_ptr<const FileBody> keep(std::string_view bytes);
  void keep_scene(JobId job, const std::filesystem::path& files);
  void make_file(File& picture, const msg::ImageData& data, const Key& key, Steps steps);

  LoopClient& loop_;
  const ChildRunner& runner_;
  Places places_{"pictures", {.places = 2, .of_one = 2, .inside = 40, .one_inside = 32}};
  Budget& memory_;
  Budget disk_;
  const std::filesystem::path directory_;
  SteadyClock clock_;
  std::mutex mutex_;  // guards entries_
  std::map<Key, std::shared_ptr<Entry>> entries_;
};

/// A file of a job: its last part of the path, and its media type.
struct PictureFile {
  PictureCache::Kind kind;
  const char* name;
  const char* type;
};
/// In the order of PictureCache::Kind.
inline constexpr std::array<PictureFile, 8> picture_files = {
    {{PictureCache::Kind::png, "image.png", "image/png"},
     {PictureCache::Kind::exr, "image.exr", "image/x-exr"},
     {PictureCache::Kind::pixels, "pixels.f32", "application/octet-stream"},
     {PictureCache::Kind::error_png, "error.png", "image/png"},
     {PictureCache::Kind::error_pixels, "error.f32", "application/octet-stream"},
     {PictureCache::Kind::cost, "cost.f32", "application/octet-stream"},
     {PictureCache::Kind::worker_numbers, "workers.u32", "application/octet-stream"},
     {PictureCache::Kind::worker_names, "workers.json", "application/json"}}};
constexpr const PictureFile& file_of(PictureCache::Kind kind) {
  return picture_files.at(static_cast<std::size_t>(kind));
}

}  // namespace parray::http
