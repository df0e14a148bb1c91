#include "coordinator/http/pictures.h"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <fstream>
#include <iterator>
#include <nlohmann/json.hpp>

#include "common/base/bytes.h"
#include "common/base/error.h"
#include "common/image/picture_bytes.h"
#include "coordinator/work_map.h"

namespace parray::http {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;
using Kind = Pictures::Kind;

/// What makes a picture is this program's own: the limits only end what hangs.
constexpr ChildLimits generous{std::uint64_t{64} << 30, 600};
// Of what is kept; the latest stays whatever its size.
constexpr std::size_t most_entries = 32;
constexpr std::size_t most_bytes = std::size_t{256} << 20;

bool of_work(Kind kind) {
  return kind == Kind::cost || kind == Kind::tracers || kind == Kind::tracer_names;
}
bool of_error(Kind kind) { return kind == Kind::error_png || kind == Kind::error_pixels; }

const char* file_of(Kind kind) {
  switch (kind) {
    case Kind::png:
      return "image.png";
    case Kind::exr:
      return "image.exr";
    case Kind::error_png:
      return "error.png";
    case Kind::error_pixels:
      return "error.f32";
    case Kind::cost:
      return "cost.f32";
    case Kind::tracers:
      return "workers.u32";
    case Kind::tracer_names:
      return "workers.json";
    case Kind::pixels:
      break;
  }
  return "pixels";
}

/// As they travel: little-endian.
template <typename T>
std::string bytes_of(const std::vector<T>& values) {
  static_assert(std::endian::native == std::endian::little);
  return {reinterpret_cast<const char*>(values.data()), values.size() * sizeof(T)};
}

void write_file(const fs::path& file, std::string_view bytes) {
  std::ofstream out(file, std::ios::binary);
  out.write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
  out.close();
  if (!out) throw Problem(503, "writing a picture failed: is the server's disk full?");
}

}  // namespace

std::shared_ptr<Pictures::Entry> Pictures::entry_of(JobId job, Kind kind) {
  const std::scoped_lock lock(mutex_);
  std::shared_ptr<Entry>& entry = entries_[{job, kind}];
  if (!entry) entry = std::make_shared<Entry>();
  entry->used_at = clock_.now();
  return entry;
}

/// Whoever still uses one has it.
void Pictures::drop_old() {
  const std::scoped_lock lock(mutex_);
  std::size_t bytes = 0;
  for (const auto& [key, entry] : entries_) bytes += entry->size;
  while (entries_.size() > 1 && (entries_.size() > most_entries || bytes > most_bytes)) {
    const auto oldest = std::ranges::min_element(
        entries_, {}, [](const auto& entry) { return entry.second->used_at; });
    bytes -= oldest->second->size;
    entries_.erase(oldest);
  }
}

Pictures::Made Pictures::get(const Sender& sender, const std::string& owner, JobId job, Kind kind) {
  const Places::Entry entrance(places_, owner);
  const json shown = loop_.ask<msg::Job>(sender, msg::ShowJob{0, job}).job;
  const bool done = shown.at("state") == name_of(JobState::done);
  const auto entry = entry_of(job, kind);
  const std::scoped_lock one_maker(entry->mutex);
  Made& made = entry->made;
  const Time now = clock_.now();
  const Time rest = std::max<Time>(seconds(1), 20 * entry->cost);
  const bool fresh = made.bytes && made.partial != done && (done || now - entry->made_at < rest);
  if (!fresh) {
    made = {};
    const Places::Place place(entrance);
    made = of_work(kind) ? make_map(sender, job, kind) : make(sender, job, kind);
    entry->made_at = clock_.now();
    entry->cost = entry->made_at - now;
    entry->size = made.bytes->size();
    drop_old();
  }
  return made;
}

Pictures::Made Pictures::make(const Sender& sender, JobId job, Kind kind) {
  const bool statistics = of_error(kind) || kind == Kind::exr;
  const auto data =
      loop_.ask<msg::ImageData>(sender, msg::Fetch{0, job, !of_error(kind), statistics, false});
  Made made;
  made.width = data.width;
  made.height = data.height;
  made.partial = data.report.value("partial", false);
  made.samples = data.report.value("samples", std::uint64_t{0});
  made.etag = '"' +
              (made.partial ? std::to_string(job) + "-" + std::to_string(made.samples)
                            : data.report.value("image_sha256", "").substr(0, 32)) +
              "-" + file_of(kind) + '"';
  try {
    made.bytes = std::make_shared<const std::string>(
        kind == Kind::pixels ? std::string(data.picture.bytes(PictureDetail::image).data.view())
                             : make_file(data, kind));
  } catch (const ChecksumError&) {
    throw RunError("the picture of job " + std::to_string(job) + " is damaged");
  }
  return made;
}

Pictures::Made Pictures::make_map(const Sender& sender, JobId job, Kind kind) {
  const auto data = loop_.ask<msg::JournalData>(sender, msg::FetchJournal{0, job});
  Made made;
  made.width = data.job.at("width").get<std::uint32_t>();
  made.height = data.job.at("height").get<std::uint32_t>();
  made.partial = data.job.at("state") != name_of(JobState::done);
  made.samples = data.report.value("samples", std::uint64_t{0});
  const std::string_view journal = data.journal.verified();
  made.etag = fmt::format("\"{}-{}-{}\"", job, journal.size(), file_of(kind));
  try {
    const WorkMap map = work_map(read_journal(journal), made.width, made.height);
    made.bytes = std::make_shared<const std::string>(
        kind == Kind::cost ? bytes_of(map.seconds)
        : kind == Kind::tracers
            ? bytes_of(map.tracer)
            : json{{"workers", map.workers}}.dump(-1, ' ', false, json::error_handler_t::replace));
  } catch (const DecodeError& error) {
    throw RunError("the journal of job " + std::to_string(job) + " is damaged: " + error.what());
  }
  return made;
}

std::string Pictures::make_file(const msg::ImageData& data, Kind kind) {
  const WorkDirectory directory(directory_);
  const fs::path files = directory.path() / "picture";
  fs::create_directory(files);
  write_file(files / "report", data.report.dump());
  write_file(files / "pixels", data.picture.bytes(detail_of(data)).data.view());
  const std::string name = file_of(kind);
  const ChildEnd end = runner_.run(
      {"picture", name, std::to_string(data.width), std::to_string(data.height)}, files, generous);
  if (end.status != 0) throw RunError("making " + name + " failed: " + end.message);
  std::ifstream in(files / name, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), {}};
}

}  // namespace parray::http
