#include <doctest/doctest.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <map>
#include <set>
#include <sstream>
#include <string>
#include <string_view>
#include <vector>

/// The arrows of the architecture, as a test: who may include whom.
namespace parray {
namespace {

namespace fs = std::filesystem;

struct SourceFile {
  std::string path;  ///< from the root of the sources, with '/'
  std::string text;
};

using Problems = std::vector<std::string>;

const std::map<std::string, std::set<std::string>>& may_include() {
  static const std::map<std::string, std::set<std::string>> rules = {
      {"common", {"common"}},
      {"proto", {"common", "proto"}},
      {"coordinator", {"coordinator", "proto", "common"}},
      {"worker", {"worker", "proto", "common"}},
      {"cli", {"cli", "coordinator", "worker", "proto", "common"}}};
  return rules;
}

std::string folder_of(const std::string& path) { return path.substr(0, path.find('/')); }

/// What #include directives of a file name, with their quotes or angles.
std::vector<std::string> includes_of(const SourceFile& file) {
  std::vector<std::string> names;
  std::istringstream lines(file.text);
  for (std::string line; std::getline(lines, line);) {
    line.erase(
        std::remove_if(line.begin(), line.end(), [](char c) { return c == ' ' || c == '\t'; }),
        line.end());
    constexpr std::string_view directive = "#include";
    if (line.compare(0, directive.size(), directive) != 0) {
      continue;
    }
    const std::string name = line.substr(directive.size());
    const char close = name.empty() || name[0] != '<' ? '"' : '>';
    const std::size_t end = name.find(close, 1);
    names.push_back(end == std::string::npos ? name : name.substr(0, end + 1));
  }
  return names;
}

/// Headers of clocks, threads and sockets: common/ is pure.
bool is_impure(const std::string& include) {
  static const std::set<std::string> headers = {
      "<chrono>",      "<thread>",  "<mutex>",        "<condition_variable>",
      "<future>",      "<ctime>",   "<time.h>",       "<omp.h>",
      "<pthread.h>",   "<netdb.h>", "<sys/socket.h>", "<sys/time.h>",
      "<arpa/inet.h>", "<zmq.hpp>", "<zmq.h>",        "<mpi.h>",
      "<sys/un.h>",    "<poll.h>",  "<httplib.h>"};
  return headers.contains(include) || include.compare(0, 9, "<netinet/") == 0;
}

Problems problems_of(const SourceFile& file) {
  constexpr std::ptrdiff_t most_lines = 500;
  Problems problems;
  const std::string folder = folder_of(file.path);
  const auto rule = may_include().find(folder);
  if (rule == may_include().end()) {
    return {file.path + " is in no known folder"};
  }
  for (const std::string& include : includes_of(file)) {
    const std::string name = include.substr(1, include.size() - 2);
    const bool quoted = include[0] == '"';
    if (quoted && !rule->second.contains(folder_of(name))) {
      problems.push_back(file.path + " may not include " + include);
    }
    if (!quoted && may_include().contains(folder_of(name)) && name.find('/') != std::string::npos) {
      problems.push_back(file.path + " includes our own " + include + " in angles");
    }
    if (folder == "common" && is_impure(include)) {
      problems.push_back(file.path + " is impure: " + include);
    }
    if (name.find("OpenImageIO") != std::string::npos &&
        file.path != "common/image/image_file.cpp") {
      problems.push_back(file.path + " may not include OpenImageIO");
    }
    if (name.starts_with("gemmi/") && file.path != "common/particles/gemmi_seam.cpp") {
      problems.push_back(file.path + " may not include gemmi");
    }
    if (name.starts_with("common/particles/") && folder != "cli" &&
        !file.path.starts_with("common/particles/")) {
      problems.push_back(file.path + " may not include readers of particle files");
    }
  }
  if (std::count(file.text.begin(), file.text.end(), '\n') > most_lines) {
    problems.push_back(file.path + " is longer than 500 lines");
  }
  return problems;
}

std::vector<SourceFile> sources() {
  std::vector<SourceFile> files;
  const fs::path root = PARRAY_SOURCE_DIR;
  for (const auto& [folder, rule] : may_include()) {
    for (const auto& entry : fs::recursive_directory_iterator(root / folder)) {
      const std::string extension = entry.path().extension().string();
      if (!entry.is_regular_file() || (extension != ".h" && extension != ".cpp")) {
        continue;
      }
      std::ifstream in(entry.path());
      std::ostringstream text;
      text << in.rdbuf();
      files.push_back({fs::relative(entry.path(), root).generic_string(), text.str()});
    }
  }
  return files;
}

bool refuses(const std::string& path, const std::string& text) {
  return !problems_of({path, text + "\n"}).empty();
}

}  // namespace

TEST_CASE("every include follows the arrows of the architecture") {
  for (const SourceFile& file : sources()) {
    for (const std::string& problem : problems_of(file)) {
      CHECK_MESSAGE(false, problem);
    }
  }
}

TEST_CASE("the scan of includes sees the sources") {
  const auto files = sources();
  std::map<std::string, std::size_t> own;
  std::size_t system = 0;
  bool image_io = false;
  for (const SourceFile& file : files) {
    CHECK_MESSAGE(!file.text.empty(), file.path);
    for (const std::string& include : includes_of(file)) {
      if (include[0] == '"') {
        ++own[folder_of(file.path)];
      } else {
        ++system;
      }
      image_io = image_io || include.find("<OpenImageIO/") == 0;
    }
  }
  CHECK(files.size() > 80);
  CHECK(own["common"] > 100);
  CHECK(own["proto"] > 20);
  CHECK(own["coordinator"] > 20);
  CHECK(own["worker"] > 8);
  CHECK(own["cli"] > 20);
  CHECK(system > 200);
  CHECK(image_io);
}

TEST_CASE("every quoted include names a file that is there") {
  const fs::path root = PARRAY_SOURCE_DIR;
  for (const SourceFile& file : sources()) {
    for (const std::string& include : includes_of(file)) {
      if (include[0] == '"') {
        CHECK_MESSAGE(fs::exists(root / include.substr(1, include.size() - 2)),
                      (file.path + " includes " + include));
      }
    }
  }
}

TEST_CASE("the check of includes refuses what the architecture forbids") {
  CHECK(refuses("common/a.h", "#include \"proto/link.h\""));
  CHECK(refuses("common/a/b.cpp", "#include \"worker/team.h\""));
  CHECK(refuses("proto/a.h", "#include \"coordinator/job.h\""));
  CHECK(refuses("coordinator/a.cpp", "#include \"worker/team.h\""));
  CHECK(refuses("coordinator/a.cpp", "#include \"cli/text.h\""));
  CHECK(refuses("worker/a.cpp", "#include \"coordinator/job.h\""));
  CHECK(refuses("worker/a.cpp", "  #  include   \"coordinator/job.h\"  // why"));
  CHECK(refuses("cli/a.cpp", "#include \"tests/support/dice.h\""));
  CHECK(refuses("worker/a.cpp", "#include \"team.h\""));
  CHECK(refuses("worker/a.cpp", "#include \"../coordinator/job.h\""));
  CHECK(refuses("worker/a.cpp", "#include <coordinator/job.h>"));
  CHECK(refuses("common/a.h", "#include <chrono>"));
  CHECK(refuses("common/a.h", "#include <thread>"));
  CHECK(refuses("common/a.h", "#include <sys/socket.h>"));
  CHECK(refuses("common/a.h", "#include <netinet/in.h>"));
  CHECK(refuses("common/image/image.cpp", "#include <OpenImageIO/imageio.h>"));
  CHECK(refuses("worker/a.cpp", "#include <OpenImageIO/imageio.h>"));
  CHECK(refuses("common/scene/a.cpp", "#include <gemmi/pdb.hpp>"));
  CHECK(refuses("worker/a.cpp", "#include \"common/particles/particles.h\""));
  CHECK(refuses("coordinator/a.cpp", "#include \"common/particles/expand.h\""));
  CHECK(refuses("common/scene/a.cpp", "#include \"common/particles/particles.h\""));
  CHECK(refuses("stray/a.cpp", ""));
  CHECK(refuses("cli/a.cpp", std::string(500, '\n')));
}

TEST_CASE("the check of includes lets through what the architecture allows") {
  CHECK_FALSE(refuses("common/a.h", "#include \"common/b.h\"\n#include <vector>"));
  CHECK_FALSE(refuses("proto/a.h", "#include \"common/b.h\"\n#include <chrono>"));
  CHECK_FALSE(refuses("worker/a.cpp", "#include \"proto/link.h\"\n#include <thread>"));
  CHECK_FALSE(refuses("cli/a.cpp", "#include \"coordinator/job.h\"\n#include \"worker/team.h\""));
  CHECK_FALSE(refuses("common/image/image_file.cpp", "#include <OpenImageIO/imageio.h>"));
  CHECK_FALSE(refuses("common/particles/a.cpp", "#include \"common/particles/particles.h\""));
  CHECK_FALSE(refuses("cli/a.cpp", "#include \"common/particles/expand.h\""));
  CHECK_FALSE(refuses("common/particles/gemmi_seam.cpp", "#include <gemmi/pdb.hpp>"));
  CHECK_FALSE(refuses("common/a.h", "// the text #include \"proto/link.h\" in a comment"));
  CHECK_FALSE(refuses("cli/a.cpp", std::string(499, '\n')));
}

}  // namespace parray
