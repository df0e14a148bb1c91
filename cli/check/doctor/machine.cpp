#include "cli/check/doctor/machine.h"

#include <spdlog/version.h>
#include <sqlite3.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdlib>
#include <fstream>
#include <limits>
#include <string>
#include <system_error>
#include <tuple>
#include <zmq.hpp>

#include "cli/output/picture/image_file.h"
#include "cli/output/picture/srgb.h"
#include "cli/output/processor.h"
#include "cli/output/text.h"
#include "common/base/cgroup_limits.h"
#include "common/base/cpu_count.h"
#include "common/base/printable.h"
#include "common/base/sha256.h"
#include "common/math/float_mode.h"
#include "common/scene/requirements.h"
#include "common/scene/settings_fwd.h"
#include "common/schedule/work_plan.h"
#include "common/trace/isa.h"
#include "coordinator/store/disk_store.h"
#include "proto/window.h"

namespace parray::doctor {
namespace {

namespace fs = std::filesystem;

/// Returns the differences from the default mode of IEEE 754. Empty: none.
std::string oddities(unsigned control) {
  std::string text;
  const auto add = [&](unsigned bits, const char* name) {
    const bool odd = ((control ^ float_control::ieee) & bits) != 0;
    if (odd) text += (text.empty() ? "" : ", ") + std::string(name);
  };
  add(float_control::denormal_results, "denormal results become 0");
  add(float_control::denormal_operands, "denormal operands count as 0");
  add(float_control::rounding, "rounding is not to nearest");
  add(float_control::exceptions, "exceptions stop the program");
  return text;
}

/// Returns a value of /proc/meminfo in bytes. 0: unknown.
std::uint64_t memory_bytes(const std::string& key) {
  std::ifstream file("/proc/meminfo");
  constexpr std::uint64_t kibibyte = 1024;
  return kibibyte * std::strtoull(value_of(file, key).c_str(), nullptr, 10);
}

/// Returns the directory of std::filesystem::temp_directory_path(), without its check: the error of
/// that check does not name the directory.
fs::path temporary_place() {
  for (const char* variable : {"TMPDIR", "TMP", "TEMP", "TEMPDIR"}) {
    const char* const place = std::getenv(variable);  // NOLINT(concurrency-mt-unsafe)
    if (place != nullptr) return place;
  }
  return "/tmp";
}

/// Returns why a file cannot be made and written in `directory`. Empty: it can.
std::string why_not_writable(const fs::path& directory) {
  std::string name = (directory / ".parray-doctor-XXXXXX").string();
  const int file = mkstemp(name.data());
  if (file < 0) return std::generic_category().message(errno);
  const bool written = write(file, "1", 1) == 1 && fsync(file) == 0;
  const int error = errno;
  close(file);
  unlink(name.c_str());
  return written ? "" : std::generic_category().message(error);
}

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
bool reads_back(const fs::path& file, const Image& image) {
  write_image(file, image, {{"Software", "ParRay"}});
  const Image found = read_image(file).image;
  return found.width == image.width && found.height == image.height &&
         image_sha256(found) == image_sha256(image);
}

}  // namespace

CheckResult check_processor() {
  const std::string model = processor_model();
  const auto cpus = static_cast<std::uint64_t>(usable_cpus());
  nlohmann::json names = nlohmann::json::array();
  std::string list;
  for (const Isa isa : instruction_sets()) {
    names.push_back(name_of(isa));
    list += (list.empty() ? "" : ", ") + std::string(name_of(isa));
  }
  CheckResult found = passed(model + ", " + counted(cpus, "CPU") + " available; kernels: " + list +
                             "; auto uses " + std::string(name_of(best_isa())));
  found.facts = {{"model", model},
                 {"cpus", cpus},
                 {"instruction_sets", names},
                 {"automatic", name_of(best_isa())}};
  return found;
}

CheckResult check_float_mode(std::span<const unsigned> found) {
  std::string odd;
  std::size_t threads = 0;
  for (const unsigned control : found) {
    const std::string here = oddities(control);
    if (!here.empty()) {
      odd = here;
      ++threads;
    }
  }
  if (threads == 0) {
    return passed("round to nearest, denormals kept, in " + counted(found.size(), "thread"));
  }
  return warned(odd + ", in " + std::to_string(threads) + " of " + counted(found.size(), "thread") +
                    " when they start",
                "tracing is not affected, because it sets its own mode; look for a library that "
                "was linked with -ffast-math (LD_PRELOAD?)");
}

CheckResult check_float_mode() {
  const int threads = usable_cpus();
  std::vector<unsigned> found(static_cast<std::size_t>(threads) + 1, float_control::ieee);
  found[0] = float_control::read();
#pragma omp parallel for num_threads(threads) schedule(static, 1)
  for (int i = 0; i < threads; ++i) found[static_cast<std::size_t>(i) + 1] = float_control::read();
  return check_float_mode(found);
}

CheckResult check_memory(std::uint64_t available, std::uint64_t total) {
  if (total == 0) return skipped("the system does not report its memory", "");
  if (available == 0) return skipped("the system does not report its available memory", "");
  const std::string text = bytes_text(available) + " available of " + bytes_text(total);
  constexpr std::uint64_t enough = std::uint64_t{256} << 20;  // a few million spheres
  CheckResult found = available >= enough
                          ? passed(text)
                          : warned(text, "end other programs before rendering large scenes");
  found.facts = {{"total_bytes", total}, {"available_bytes", available}};
  return found;
}

CheckResult check_memory() {
  const std::uint64_t total = std::min(memory_bytes("MemTotal"), usable_memory());
  return check_memory(std::min(memory_bytes("MemAvailable"), total), total);
}

CheckResult check_temporary_directory(std::optional<OwnedPath>& scratch) {
  const std::string remedy = "set TMPDIR to a writable directory with free space";
  const fs::path parent = temporary_place();
  const fs::path path = make_directory(parent / "parray-doctor-");
  if (path.empty()) {
    return failed(parent.string() + ": " + std::generic_category().message(errno), remedy);
  }
  scratch.emplace(path);
  const std::string place = printable(path.parent_path().string(), 200);
  const std::string problem = why_not_writable(path);
  if (!problem.empty()) return failed(place + ": " + problem, remedy);
  std::error_code ignored;
  const auto space = fs::space(path, ignored);
  return passed(place + ", " + bytes_text(ignored ? 0 : space.available) + " free");
}

CheckResult check_current_directory(const fs::path& directory) {
  const std::string problem = why_not_writable(directory);
  return problem.empty() ? passed("writable")
                         : warned(problem, "write pictures to another directory with -o");
}

std::uint64_t window_bytes() {
  const Boxed<RenderSettings> defaults;
  const auto settings = resolve_settings(requirements_of({}), defaults).settings;
  const WorkPlan plan(settings, {{{0, samples_per_pixel_of(settings)}}, {}});
  const auto ranks = static_cast<std::uint32_t>(usable_cpus());
  constexpr std::uint64_t own_of_rank = 4 << 20;  // Open MPI's buffers (btl_vader_segment_size)
  return WindowLayout(*plan.grid(), ranks).bytes() + ranks * own_of_rank;
}

CheckResult check_shared_memory(std::uint64_t available, std::uint64_t needed) {
  const std::string text = bytes_text(available) + " free in /dev/shm; a picture of 1200 x 800 " +
                           "under MPI needs " + bytes_text(needed);
  CheckResult found =
      available >= needed
          ? passed(text)
          : warned(text,
                   "enlarge /dev/shm (mount -o remount,size=1g /dev/shm; for a container "
                   "--shm-size=1g), or use parray-mpi --mode messages");
  found.facts = {{"available_bytes", available}, {"needed_bytes", needed}};
  return found;
}

CheckResult check_shared_memory() {
  std::error_code problem;
  const auto space = fs::space("/dev/shm", problem);
  if (problem) {
    return skipped("no /dev/shm: " + problem.message(), "use parray-mpi --mode messages");
  }
  return check_shared_memory(space.available, window_bytes());
}

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

CheckResult check_pictures(const fs::path& directory) {
  const bool exr = reads_back(directory / "trial.exr", extreme_image());
  const bool png = reads_back(directory / "trial.png", byte_image());
  if (exr && png) return passed("EXR and PNG files contain the values that were written");
  return failed(std::string(exr ? "" : "EXR") + (exr || png ? "" : " and ") + (png ? "" : "PNG") +
                    " files contain other values than were written",
                std::string("reinstall ") + (exr ? "" : "OpenEXR (Debian: libopenexr-3-1-30)") +
                    (exr || png ? "" : " and ") + (png ? "" : "libpng (Debian: libpng16-16)"));
}

CheckResult check_state(const fs::path& directory) {
  const fs::path place = directory / "state";
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
