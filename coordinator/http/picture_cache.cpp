#include "coordinator/http/picture_cache.h"

#include <fmt/format.h>
#include <malloc.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include "common/base/bytes.h"
#include "common/base/error.h"
#include "common/base/files.h"
#include "common/base/json_text.h"
#include "common/image/picture_bytes.h"
#include "coordinator/jobs/work_map.h"
#include "proto/settings_json.h"

namespace parray::http {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;
using Kind = PictureCache::Kind;

/// Child processes that make pictures are trusted. Their limits only end processes that hang.
constexpr Time memory_patience = seconds(20);
constexpr ChildLimits generous{std::uint64_t{64} << 30, 600};
// Limits of the cache. The latest file stays in it, whatever its size.
constexpr std::size_t most_files = 32;
constexpr std::size_t most_file_bytes = std::size_t{256} << 20;  // on the disk
constexpr std::size_t most_thumbnails = 2000;                    // a page of 500 jobs shows as many
constexpr std::size_t most_thumbnail_bytes = std::size_t{32} << 20;  // in memory

bool is_work_map(Kind kind) {
  return kind == Kind::cost || kind == Kind::worker_numbers || kind == Kind::worker_names;
}
bool is_error_map(Kind kind) { return kind == Kind::error_png || kind == Kind::error_pixels; }

/// Returns a text that is the same as long as the picture of a job does not change. Empty: it
/// changes, because the job has not ended.
std::string version_of(const json& job) {
  const std::string state = job.at("state");
  const bool stopped = state == name_of(JobState::failed) || state == name_of(JobState::cancelled);
  return state == name_of(JobState::done) ? state
         : stopped ? job.at("finished").dump() + job.at("samples_taken").dump()
                   : "";
}

/// Returns the bytes as they are sent: little-endian.
template <typename T>
std::string_view bytes_of(const std::vector<T>& values) {
  return {reinterpret_cast<const char*>(values.data()), values.size() * sizeof(T)};
}

void keep_file(const fs::path& file, std::string_view bytes) {
  if (!write_file(file, bytes)) {
    throw Problem(503, "writing a picture failed: the server's disk may be full");
  }
}

}  // namespace

/// Returns the steps for a file of a job: none unless it is done.
PictureCache::Steps PictureCache::steps_of(const json& job, const Key& key) {
  if (job.at("state") != name_of(JobState::done) || is_work_map(key.kind) ||
      is_error_map(key.kind)) {
    return {};
  }
  const bool draws = key.kind == Kind::png && key.thumbnail_width == 0;
  return {job.value("denoise", false), draws && job.value("drawn", false)};
}

/// Returns the memory in bytes that this process needs while it makes the file. With steps, also
/// what the child process needs beside the scene.
std::uint64_t PictureCache::memory_of(const json& job, Kind kind, Steps steps) {
  const auto width = job.at("width").get<std::uint64_t>();
  const auto height = job.at("height").get<std::uint64_t>();
  constexpr std::uint64_t of_pixel_in_steps = 400;
  const bool small = (kind == Kind::png || kind == Kind::pixels) && !steps.draw;
  return 2 * picture_size(width, height,
                          steps.denoise ? PictureDetail::replicates
                          : small       ? PictureDetail::image
                                        : PictureDetail::statistics) +
         (steps.any() ? of_pixel_in_steps * width * height : 0);
}

std::shared_ptr<PictureCache::Entry> PictureCache::entry_of(const Key& key) {
  const std::scoped_lock lock(mutex_);
  std::shared_ptr<Entry>& entry = entries_[key];
  if (!entry) entry = std::make_shared<Entry>();
  entry->used_at = clock_.now();
  return entry;
}

/// Removes the thumbnails, or the other files, that were used least recently. Requests that use a
/// removed file keep it. One of them stays, whatever its size.
void PictureCache::drop_old(bool thumbnails, std::size_t most_entries, std::size_t most_bytes) {
  const std::scoped_lock lock(mutex_);
  std::vector<std::pair<Time, Key>> by_use;
  std::size_t bytes = 0;
  for (const auto& [key, entry] : entries_) {
    if ((key.thumbnail_width > 0) != thumbnails) continue;
    by_use.emplace_back(entry->used_at, key);
    bytes += entry->size;
  }
  std::size_t left = by_use.size();
  if (left <= most_entries && bytes <= most_bytes) return;
  std::ranges::sort(by_use);
  for (const auto& [used_at, key] : by_use) {
    if (left <= 1 || (left <= most_entries && bytes <= most_bytes)) return;
    bytes -= entries_.at(key)->size;
    entries_.erase(key);
    --left;
  }
}

PictureCache::File PictureCache::get(const Sender& sender, const std::string& owner, JobId job,
                                     Kind kind, std::uint32_t thumbnail_width) {
  const Key key{job, kind, thumbnail_width};
  const bool small = thumbnail_width > 0;
  const Places::Entry entrance(places_, owner);
  const json shown = loop_.ask<msg::Job>(sender, msg::ShowJob{0, job}).job;
  const std::string version = version_of(shown);
  const auto entry = entry_of(key);
  const std::scoped_lock one_maker(entry->mutex);
  File& picture = entry->picture;
  const Time now = clock_.now();
  const Time rest = std::max<Time>(seconds(1), 20 * entry->cost);
  const bool made = picture.file || picture.thumbnail;
  const bool fresh = made && (version.empty() ? picture.partial && now - entry->made_at < rest
                                              : version == entry->version);
  if (!fresh) {
    picture = {};
    const Places::Place place(entrance);
    const Steps steps = steps_of(shown, key);
    const auto needed = memory_of(shown, kind, steps);
    {
      const auto held = memory_.hold(needed, memory_patience, "another picture");
      picture = is_work_map(kind) ? make_map(sender, job, kind) : make(sender, key, steps);
    }
    // Returns freed memory to the system: the C library keeps it in each thread's arena.
    constexpr std::uint64_t little = std::uint64_t{8} << 20;
    if (needed >= little) malloc_trim(0);
    entry->version = version;
    entry->made_at = clock_.now();
    entry->cost = entry->made_at - now;
    entry->size = small ? picture.thumbnail->size() : picture.file->bytes().size();
    drop_old(small, small ? most_thumbnails : most_files,
             small ? most_thumbnail_bytes : most_file_bytes);
  }
  return picture;
}

PictureCache::File PictureCache::make(const Sender& sender, const Key& key, Steps steps) {
  const auto [job, kind, thumbnail_width] = key;
  const bool statistics = is_error_map(kind) || kind == Kind::exr || steps.draw;
  const auto data =
      loop_.ask<msg::ImageData>(sender, msg::Fetch{0, job, true, statistics, steps.denoise});
  File picture;
  picture.width = data.width;
  picture.height = data.height;
  picture.partial = data.report.value("partial", false);
  const auto samples = data.report.value("samples", std::uint64_t{0});
  picture.samples = samples;
  picture.etag = '"' +
                 (picture.partial ? std::to_string(job) + "-" + std::to_string(samples)
                                  : data.report.value("image_sha256", "").substr(0, 32)) +
                 (steps.denoise ? "-denoised-" : "-") + file_of(kind).name +
                 (thumbnail_width > 0 ? "-" + std::to_string(thumbnail_width) : "") + '"';
  try {
    if (kind == Kind::pixels && !steps.denoise) {
      picture.file = keep(data.picture.bytes(PictureDetail::image).data.view());
    } else {
      make_file(picture, data, key, steps);
    }
  } catch (const ChecksumError&) {
    throw RunError("the picture of job " + std::to_string(job) + " is damaged");
  }
  return picture;
}

PictureCache::File PictureCache::make_map(const Sender& sender, JobId job, Kind kind) {
  const auto data = loop_.ask<msg::JournalData>(sender, msg::FetchJournal{0, job});
  File picture;
  picture.width = data.job.at("width").get<std::uint32_t>();
  picture.height = data.job.at("height").get<std::uint32_t>();
  picture.partial = data.job.at("state") != name_of(JobState::done);
  const std::string_view journal = data.journal.verified();
  picture.etag = fmt::format("\"{}-{}-{}\"", job, journal.size(), file_of(kind).name);
  try {
    const WorkMap map = work_map(read_journal(journal), picture.width, picture.height);
    const std::string names = json_text({{"workers", map.workers}});
    picture.file = keep(kind == Kind::cost             ? bytes_of(map.seconds)
                        : kind == Kind::worker_numbers ? bytes_of(map.tracer)
                                                       : std::string_view(names));
  } catch (const DecodeError& error) {
    throw RunError(damaged_journal(job, error.what()));
  }
  return picture;
}

/// Keeps a file of a picture. If the disk budget is used up, deletes files that no client reads.
std::shared_ptr<const FileBody> PictureCache::keep(const fs::path& file) {
  try {
    return std::make_shared<const FileBody>(file, disk_);
  } catch (const Problem&) {
    drop_old(false, 1, 0);
    return std::make_shared<const FileBody>(file, disk_);
  }
}

std::shared_ptr<const FileBody> PictureCache::keep(std::string_view bytes) {
  const OwnedPath directory = work_directory(directory_);
  keep_file(directory.path() / "file", bytes);
  return keep(directory.path() / "file");
}

/// Writes what the steps need beside the picture. Every user sees their results, but only the owner
/// may get the scene, so this process asks for itself.
void PictureCache::keep_scene(JobId job, const fs::path& files) {
  const auto answer = loop_.ask<msg::SceneData>({}, msg::FetchScene{0, job});
  keep_file(files / "settings", settings_to_json(answer.settings).dump());
  keep_file(files / "scene", answer.scene.bytes().data.view());
  keep_file(files / "drawing", answer.drawing);
}

/// Makes the file in a child process, and puts it into `picture`.
void PictureCache::make_file(File& picture, const msg::ImageData& data, const Key& key,
                             Steps steps) {
  const OwnedPath directory = work_directory(directory_);
  const fs::path files = directory.path() / "picture";
  fs::create_directory(files);
  keep_file(files / "report", data.report.dump());
  keep_file(files / "pixels", data.picture.bytes(detail_of(data)).data.view());
  const std::string name = file_of(key.kind).name;
  std::vector<std::string> words = {"picture", name, std::to_string(data.width),
                                    std::to_string(data.height)};
  const bool small = key.thumbnail_width > 0;
  if (small) words.push_back("--thumbnail-width=" + std::to_string(key.thumbnail_width));
  if (steps.any()) keep_scene(key.job, files);
  if (steps.denoise) words.emplace_back("--denoise");
  if (steps.draw) words.emplace_back("--draw");
  const ChildEnd end = runner_.run(words, files, generous);
  if (end.timed_out && steps.denoise) {
    throw Problem(503, "denoising takes too long here: parray fetch " + std::to_string(key.job) +
                           " denoises on your machine");
  }
  if (end.status != 0) throw RunError("making " + name + " failed: " + end.message);
  if (!small) {
    picture.file = keep(files / name);
  } else if (auto bytes = read_file(files / name)) {
    picture.thumbnail = std::make_shared<const std::string>(*std::move(bytes));
  } else {
    throw RunError("reading " + name + " failed");
  }
}

}  // namespace parray::http
