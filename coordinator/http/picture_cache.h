#pragma once

#include <atomic>
#include <cstdint>
#include <filesystem>
#include <map>
#include <memory>
#include <mutex>
#include <string>

#include "coordinator/http/budget.h"
#include "coordinator/http/child.h"
#include "coordinator/http/file_body.h"
#include "coordinator/http/loop_client.h"
#include "coordinator/http/places.h"
#include "coordinator/store/job_record.h"

namespace parray::http {

/// PictureCache of jobs as files, of unfinished ones, too. The loop hands over what there is; files
/// are made by a child, kept for a while, and shared by all who look: of an unfinished job a new
/// one at most once a second, and such that making them takes a twentieth of the time. Any thread.
class PictureCache {
 public:
  enum class Kind : std::uint8_t {
    png,
    exr,
    pixels,
    error_png,
    error_pixels,
    cost,
    tracers,
    tracer_names
  };

  /// `directory`: for what children read and write, and for what is kept: `disk`. `memory`: for
  /// what is needed while one is made. The others must outlive this.
  PictureCache(LoopClient& loop, const ChildRunner& runner, Places& places, Budget& memory,
               Budget& disk, std::filesystem::path directory)
      : loop_(loop),
        runner_(runner),
        places_(places),
        memory_(memory),
        disk_(disk),
        directory_(std::move(directory)) {}

  struct Made {
    std::shared_ptr<const FileBody> file;
    std::string etag;
    std::uint32_t width = 0;
    std::uint32_t height = 0;
    std::uint64_t samples = 0;  ///< of all pixels together
    bool partial = false;       ///< the job is not done
  };
  /// Throws Problem: there is no such job, or nothing to show yet, or, of maps of the error, it is
  /// not done. `owner`: in whose turn it is made.
  Made get(const Sender& sender, const std::string& owner, JobId job, Kind kind);

 private:
  struct Entry {
    std::mutex mutex;  ///< guards the three below
    Made made;
    Time made_at{};
    Time cost{};
    std::atomic<std::size_t> size = 0;  ///< of made.file
    Time used_at{};                     ///< guarded by PictureCache::mutex_
  };
  std::shared_ptr<Entry> entry_of(JobId job, Kind kind);
  void drop_old(std::size_t entries, std::size_t bytes);
  Made make_any(const Sender& sender, JobId job, Kind kind);
  Made make(const Sender& sender, JobId job, Kind kind);
  Made make_map(const Sender& sender, JobId job, Kind kind);
  std::shared_ptr<const FileBody> keep(const std::filesystem::path& file);
  std::shared_ptr<const FileBody> keep(std::string_view bytes);
  std::shared_ptr<const FileBody> make_file(const msg::ImageData& data, Kind kind);

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
