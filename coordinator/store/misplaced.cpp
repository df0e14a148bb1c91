#include "coordinator/store/misplaced.h"

#include <algorithm>
#include <system_error>

#include "common/base/error.h"

namespace parray::store {
namespace {

namespace fs = std::filesystem;

std::string_view kind_of(fs::file_type type) {
  switch (type) {
    case fs::file_type::regular: return "a file";
    case fs::file_type::directory: return "a directory";
    case fs::file_type::fifo: return "a pipe";
    case fs::file_type::socket: return "a socket";
    case fs::file_type::block:
    case fs::file_type::character: return "a device";
    default: return "no file";
  }
}

class Search {
 public:
  explicit Search(const StateFiles& files) : files_(files) {}

  std::vector<Misplaced> run() {
    for (const fs::path& file : {files_.database(), files_.notes_json(), files_.notes_next(),
                                 files_.commits(), files_.incomplete(), files_.reserve()}) {
      expect_file(file);
      expect_file(StateFiles::temporary(file));
    }
    for (const char* suffix : {"-wal", "-shm", "-journal", ".new", ".new-journal"}) {
      expect_file(files_.database().string() + suffix);
    }
    expect_directory(files_.lost());
    for (const fs::path& directory : {files_.scenes(), files_.jobs()}) expect_directory(directory);
    expect_files_in(files_.scenes());
    for (const JobId id : files_.jobs_with_directory()) {
      expect_directory(files_.job(id));
      expect_files_in(files_.job(id));
    }
    return std::move(found_);
  }

 private:
  void expect_file(const fs::path& path) { expect(path, fs::file_type::regular); }
  void expect_directory(const fs::path& path) { expect(path, fs::file_type::directory); }

  void expect(const fs::path& path, fs::file_type type) {
    std::error_code error;
    const fs::file_status status = fs::status(path, error);
    if (!fs::exists(status) || status.type() == type) return;
    found_.push_back({path, path.lexically_relative(files_.directory()).string() + " is " +
                                std::string(kind_of(status.type())) + ", not " +
                                std::string(kind_of(type))});
  }

  void expect_files_in(const fs::path& directory) {
    std::error_code error;
    std::vector<fs::path> paths;
    for (fs::directory_iterator entry(directory, error), end; !error && entry != end;
         entry.increment(error)) {
      if (StateFiles::is_file_name(entry->path().filename().string())) {
        paths.push_back(entry->path());
      }
    }
    std::ranges::sort(paths);
    std::ranges::for_each(paths, [this](const fs::path& path) { expect_file(path); });
  }

  const StateFiles& files_;
  std::vector<Misplaced> found_;
};

}  // namespace

std::vector<Misplaced> find_misplaced(const StateFiles& files) { return Search(files).run(); }

std::vector<std::string> move_misplaced_to_lost(StateFiles& files,
                                                const std::vector<Misplaced>& misplaced,
                                                std::uint64_t uptime) {
  std::vector<std::string> lines;
  for (const auto& [path, line] : misplaced) {
    if (!files.move_to_lost(path, uptime)) {
      throw RunError(line + ", and it cannot be moved to " + files.lost().string() +
                     ": move it away yourself");
    }
    lines.push_back(line + ": moved to lost/" + std::to_string(uptime));
  }
  return lines;
}

}  // namespace parray::store
