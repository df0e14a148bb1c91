#pragma once

#include <atomic>
#include <cstdint>
#include <filesystem>
#include <map>
#include <memory>
#include <mutex>
#include <nlohmann/json_fwd.hpp>
#include <string>

#include "coordinator/http/budget.h"
#include "coordinator/http/child.h"
#include "coordinator/http/file_body.h"
#include "coordinator/http/loop_client.h"
#include "coordinator/http/places.h"
#include "coordinator/store/job_record.h"

namespace parray::http {

/// Makes and caches files of pictures, including those of unfinished jobs. The loop delivers the
/// data, and a child process makes the file, which all clients share. An unfinished job gets a new
/// file at most once per second, and making files takes at most 5 % of the time. The pictures of a
/// done job are denoised, and the PNG file gets labels, if the job asks for it. Callable from any
/// thread.
class PictureCache {
 public:
  enum class Kind : std::uint8_t {
    png,
    exr,
    pixels,
    error_png,
    error_pixels,
    cost,
    worker_numbers,
    worker_names
  };

  /// `directory`: for files of child processes and cached files. `memory`: limits the memory of
  /// pictures that are being made. `disk`: limits the cached files. All references must outlive
  /// this object.
  PictureCache(LoopClient& loop, const ChildRunner& runner, Places& places, Budget& memory,
               Budget& disk, std::filesystem::path directory)
      : loop_(loop),
        runner_(runner),
        places_(places),
        memory_(memory),
        disk_(disk),
        directory_(std::move(directory)) {}

  /// A file with its properties.
  struct File {
    std::shared_ptr<const FileBody> file;
    std::string etag;
    std::uint32_t width = 0;
    std::uint32_t height = 0;
    std::uint64_t samples = 0;  ///< samples of all pixels together
    bool partial = false;       ///< the job is not done
  };
  /// Returns the cached file, or makes it. `owner`: waits for its turn under this name. Throws
  /// Problem if the job does not exist, if it has no samples yet, or if an error map is requested
  /// before the job is done.
  File get(const Sender& sender, const std::string& owner, JobId job, Kind kind);

 private:
  struct Entry {
    std::mutex mutex;  ///< guards `picture`, `made_at` and `cost`
    File picture;
    Time made_at{};
    Time cost{};
    std::atomic<std::size_t> size = 0;  ///< bytes of picture.file
    Time used_at{};                     ///< guarded by PictureCache::mutex_
  };
  std::shared_ptr<Entry> entry_of(JobId job, Kind kind);
  void drop_old(std::size_t entries, std::size_t bytes);
  /// What happens to a picture before its file is written.
  struct Steps {
    bool denoise = false;
    bool draw = false;  ///< labels, outlines, background

    [[nodiscard]] bool any() const { return denoise || draw; }
  };
  static Steps steps_of(const nlohmann::json& job, Kind kind);
  static std::uint64_t memory_of(const nlohmann::json& job, Kind kind, Steps steps);
  File make_any(const Sender& sender, JobId job, Kind kind, Steps steps);
  File make(const Sender& sender, JobId job, Kind kind, Steps steps);
  File make_map(const Sender& sender, JobId job, Kind kind);
  std::shared_ptr<const FileBody> keep(const std::filesystem::path& file);
  std::shared_ptr<const FileBody> keep(std::string_view bytes);
  void keep_scene(JobId job, const std::filesystem::path& files);
  std::shared_ptr<const FileBody> make_file(const msg::ImageData& data, JobId job, Kind kind,
                                            Steps steps);

  LoopClient& loop_;
  const ChildRunner& runner_;
  Places& places_;
  Budget& memory_;
  Budget& disk_;
  const std::filesystem::path directory_;
  SteadyClock clock_;
  std::mutex mutex_;  // guards entries_
  std::map<std::pair<JobId, Kind>, std::shared_ptr<Entry>> entries_;
};

}  // namespace parray::http
