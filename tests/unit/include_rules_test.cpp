#include <doctest/doctest.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <map>
#include <set>
#include <sstream>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "tests/support/rooms.h"

/// The arrows of the architecture, as a test: who may include whom.
namespace parray {
namespace {

namespace fs = std::filesystem;

struct SourceFile {
  std::string path;  ///< from the root of the sources, with '/'
  std::string text;
};

using Problems = std::vector<std::string>;

using Rules = std::map<std::string, std::set<std::string>>;

/// Between folders.
const Rules& may_include() {
  static const Rules rules = {{"common", {"common"}},
                              {"proto", {"common", "proto"}},
                              {"coordinator", {"coordinator", "proto", "common"}},
                              {"worker", {"worker", "proto", "common"}},
                              {"cli", {"cli", "coordinator", "worker", "proto", "common"}}};
  return rules;
}

/// Between rooms, the folders inside them; what is in no room is free. Below each room stand only
/// rooms that are listed before it. What parray_room() links in CMake says the same.
const Rules& room_may_include() {
  static const Rules rules = {
      {"common/base", {}},
      {"common/process", {"common/base"}},
      {"common/log", {"common/base", "common/process"}},
      {"common/math", {}},
      {"common/scene", {"common/base", "common/math"}},
      {"common/image", {"common/base", "common/math", "common/scene"}},
      {"common/schedule", {"common/base", "common/image", "common/scene"}},
      {"common/adaptive",
       {"common/base", "common/math", "common/image", "common/scene", "common/schedule"}},
      {"common/trace", {"common/base", "common/math", "common/scene", "common/image"}},
      {"proto", {"common/base", "common/math", "common/scene", "common/image", "common/schedule"}},
      {"worker",
       {"common/base", "common/math", "common/scene", "common/image", "common/schedule",
        "common/trace", "common/process", "common/log"}},
      {"coordinator",
       {"common/base", "common/math", "common/scene", "common/image", "common/adaptive",
        "common/schedule", "common/trace", "common/process", "common/log"}},
      {"cli/child_process", {}},
      {"cli/output/picture", {}},
      {"cli/input", {"cli/output/picture"}},
      {"cli/farm", {"cli/output/picture"}},
      {"cli/output/labels", {"cli/output/picture", "cli/input"}},
      {"cli/output/postprocess",
       {"cli/output/picture", "cli/input", "cli/farm", "cli/output/labels"}},
      {"cli/output/denoise", {}},
      {"cli/output",
       {"cli/farm", "cli/input", "cli/output/picture", "cli/output/labels",
        "cli/output/postprocess", "cli/output/denoise"}},
      {"cli/check/audit", {}},
      {"cli/check/compare", {"cli/output/picture"}},
      {"cli/check/verify", {"cli/farm", "cli/input", "cli/output", "cli/output/picture"}},
      {"cli/measure/plan",
       {"cli/output", "cli/output/picture", "cli/output/denoise", "cli/farm", "cli/check/audit"}},
      {"cli/measure/tradeoff",
       {"cli/measure/plan", "cli/output", "cli/output/picture", "cli/output/denoise", "cli/farm",
        "cli/child_process"}},
      {"cli/check/doctor",
       {"cli/output", "cli/output/picture", "cli/child_process", "cli/farm", "cli/input"}},
      {"cli/commands",
       {"cli/farm", "cli/input", "cli/output", "cli/output/picture", "cli/output/labels",
        "cli/output/postprocess", "cli/output/denoise", "cli/check/audit", "cli/check/compare",
        "cli/check/verify", "cli/check/doctor", "cli/measure/plan", "cli/measure/tradeoff",
        "cli/child_process"}},
      {"cli/scene_sandbox",
       {"cli/farm", "cli/input", "cli/output", "cli/output/picture", "cli/commands",
        "cli/measure/plan"}},
      {"cli/referee", {}},
      {"cli/mpi",
       {"cli/farm", "cli/input", "cli/output", "cli/output/picture", "cli/output/postprocess",
        "cli/commands"}}};
  return rules;
}

std::string folder_of(const std::string& path) { return path.substr(0, path.find('/')); }

/// The innermost room that a file lies in: "common/trace" of "common/trace/bvh/a.h". Files in no
/// room get their top folder.
std::string room_of(const std::string& path) {
  for (std::size_t end = path.rfind('/'); end != std::string::npos && end > 0;
       end = path.rfind('/', end - 1)) {
    if (room_may_include().contains(path.substr(0, end))) return path.substr(0, end);
  }
  return folder_of(path);
}

bool room_allows(const std::string& file, const std::string& name) {
  const std::string room = room_of(file);
  const std::string other = room_of(name);
  const auto rule = room_may_include().find(room);
  if (rule == room_may_include().end() || room == other) return true;
  // The command line may use everything outside of it: the table of folders says so.
  const bool inside =
      room.starts_with("cli/") ? other.starts_with("cli/") : other.starts_with("common/");
  return !inside || rule->second.contains(other);
}

constexpr std::string_view tracer_folder = "common/trace/";

/// The tracer's rooms from the bottom up: a file may include those of its own level and below.
int level_in_tracer(const std::string& path) {
  static const std::vector<std::pair<std::string, int>> levels = {
      {"bvh/", 1},    {"integrator/", 2}, {"reference/", 3},
      {"device/", 3}, {"tracer.", 4},     {"selfcheck/", 5}};
  const std::string place = path.substr(tracer_folder.size());
  for (const auto& [room, level] : levels) {
    if (place.starts_with(room)) return level;
  }
  return 0;
}

bool in_tracer(const std::string& path) { return path.starts_with(tracer_folder); }

/// What #include directives of a file name, with their quotes or angles.
std::vector<std::string> includes_of(const SourceFile& file) {
  std::vector<std::string> names;
  std::istringstream lines(file.text);
  for (std::string line; std::getline(lines, line);) {
    line.erase(
        std::remove_if(line.begin(), line.end(), [](char c) { return c == ' ' || c == '\t'; }),
        line.end());
    constexpr std::string_view directive = "#include";
    if (line.compare(0, directive.size(), directive) != 0) continue;
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
  if (rule == may_include().end()) return {file.path + " is in no known folder"};
  for (const std::string& include : includes_of(file)) {
    const std::string name = include.substr(1, include.size() - 2);
    const bool quoted = include[0] == '"';
    if (quoted && !rule->second.contains(folder_of(name))) {
      problems.push_back(file.path + " may not include " + include);
    }
    if (quoted && !room_allows(file.path, name)) {
      problems.push_back(room_of(file.path) + " may not include " + room_of(name) + ": " +
                         file.path + " includes " + include);
    }
    if (!quoted && may_include().contains(folder_of(name)) && name.find('/') != std::string::npos) {
      problems.push_back(file.path + " includes our own " + include + " in angles");
    }
    if (in_tracer(file.path) && in_tracer(name) &&
        level_in_tracer(name) > level_in_tracer(file.path)) {
      problems.push_back(file.path + " may not include " + include + ", a room above it");
    }
    if (folder == "common" && is_impure(include)) {
      problems.push_back(file.path + " is impure: " + include);
    }
    if (name.find("OpenImageIO") != std::string::npos &&
        file.path != "cli/output/picture/image_codec.cpp") {
      problems.push_back(file.path + " may not include OpenImageIO");
    }
    if (name.starts_with("OpenEXR/") && file.path != "cli/output/picture/exr_codec.cpp") {
      problems.push_back(file.path + " may not include OpenEXR");
    }
    if (name == "png.h" && file.path != "cli/output/picture/png_file.cpp") {
      problems.push_back(file.path + " may not include libpng");
    }
    if (name == "ft2build.h" && file.path != "cli/output/labels/font.cpp") {
      problems.push_back(file.path + " may not include FreeType");
    }
    if (name.starts_with("gemmi/") && file.path != "cli/input/formats/gemmi_seam.cpp") {
      problems.push_back(file.path + " may not include gemmi");
    }
    if (in_tracer(file.path) && in_tracer(name) &&
        level_in_tracer(name) > level_in_tracer(file.path)) {
      problems.push_back(file.path + " may not include " + include + ", a room above it");
    }
    if (name.starts_with("CLI/") && file.path != "common/process/command_line.cpp") {
      problems.push_back(file.path + " may not include CLI11");
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
      if (!entry.is_regular_file() || (extension != ".h" && extension != ".cpp")) continue;
      std::ifstream in(entry.path());
      std::ostringstream text;
      text << in.rdbuf();
      files.push_back({fs::relative(entry.path(), root).generic_string(), text.str()});
    }
  }
  return files;
}

/// The namespace of a room: the last part of its folder's path.
std::string namespace_of(const std::string& path) {
  static const std::vector<std::string> own = {"coordinator/store", "coordinator/replica",
                                               "coordinator/http"};
  for (const std::string& room : own) {
    if (path.starts_with(room + "/")) return room.substr(room.rfind('/') + 1);
  }
  const std::string room = room_of(path);
  return room.substr(room.rfind('/') + 1);
}

bool refuses(const std::string& path, const std::string& text) {
  return !problems_of({path, text + "\n"}).empty();
}

}  // namespace

TEST_CASE("every include follows the arrows of the architecture") {
  for (const SourceFile& file : sources()) {
    for (const std::string& problem : problems_of(file)) CHECK_MESSAGE(false, problem);
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

TEST_CASE("every header declares its names in the namespace of its room") {
  std::size_t declared = 0;
  for (const SourceFile& file : sources()) {
    const std::size_t at = file.text.rfind("\nnamespace parray::");
    if (!file.path.ends_with(".h") || at == std::string::npos) continue;
    const std::string last = file.text.substr(at, file.text.find('{', at) - at);
    const std::string expected = "\nnamespace parray::" + namespace_of(file.path);
    CHECK_MESSAGE((last == expected + " " || last.starts_with(expected + "::")),
                  (file.path + ":" + last));
    ++declared;
  }
  CHECK(declared > 200);
}

TEST_CASE("the check of includes refuses what the architecture forbids") {
  CHECK(refuses("common/a.h", "#include \"proto/link.h\""));
  CHECK(refuses("common/a/b.cpp", "#include \"worker/team.h\""));
  CHECK(refuses("proto/a.h", "#include \"coordinator/jobs/job.h\""));
  CHECK(refuses("coordinator/a.cpp", "#include \"worker/team.h\""));
  CHECK(refuses("coordinator/a.cpp", "#include \"cli/output/text.h\""));
  CHECK(refuses("worker/a.cpp", "#include \"coordinator/jobs/job.h\""));
  CHECK(refuses("worker/a.cpp", "  #  include   \"coordinator/jobs/job.h\"  // why"));
  CHECK(refuses("cli/a.cpp", "#include \"tests/support/dice.h\""));
  CHECK(refuses("worker/a.cpp", "#include \"team.h\""));
  CHECK(refuses("worker/a.cpp", "#include \"../coordinator/job.h\""));
  CHECK(refuses("worker/a.cpp", "#include <coordinator/jobs/job.h>"));
  CHECK(refuses("common/a.h", "#include <chrono>"));
  CHECK(refuses("common/a.h", "#include <thread>"));
  CHECK(refuses("common/a.h", "#include <sys/socket.h>"));
  CHECK(refuses("common/a.h", "#include <netinet/in.h>"));
  CHECK(refuses("common/image/image.cpp", "#include <OpenImageIO/imageio.h>"));
  CHECK(refuses("worker/a.cpp", "#include <OpenImageIO/imageio.h>"));
  CHECK(refuses("cli/output/picture/image_file.cpp", "#include <png.h>"));
  CHECK(refuses("cli/output/labels/labels.cpp", "#include <ft2build.h>"));
  CHECK(refuses("cli/output/labels/a.h", "#include \"cli/output/text.h\""));
  CHECK(refuses("common/scene/a.cpp", "#include <gemmi/pdb.hpp>"));
  CHECK(refuses("worker/a.cpp", "#include \"cli/input/particles/particles.h\""));
  CHECK(refuses("coordinator/a.cpp", "#include \"cli/input/particles/selected_particles.h\""));
  CHECK(refuses("common/scene/a.cpp", "#include \"cli/input/particles/particles.h\""));
  CHECK(refuses("common/trace/ray.h", "#include \"common/trace/bvh/bvh_view.h\""));
  CHECK(refuses("common/trace/bvh/a.h", "#include \"common/trace/integrator/path.h\""));
  CHECK(refuses("common/trace/integrator/a.h", "#include \"common/trace/reference/octree.h\""));
  CHECK(refuses("common/trace/integrator/a.h", "#include \"common/trace/tracer.h\""));
  CHECK(refuses("common/trace/integrator/a.h", "#include \"common/trace/device/device_view.h\""));
  CHECK(refuses("common/math/a.h", "#include \"common/base/error.h\""));
  CHECK(refuses("common/image/a.h", "#include \"common/schedule/cell_grid.h\""));
  CHECK(refuses("common/scene/a.h", "#include \"common/trace/ray.h\""));
  CHECK(refuses("proto/a.h", "#include \"common/trace/ray.h\""));
  CHECK(refuses("proto/a.h", "#include \"common/process/command_line.h\""));
  CHECK(refuses("cli/output/a.h", "#include \"cli/commands/options.h\""));
  CHECK(refuses("cli/check/compare/a.h", "#include \"cli/output/text.h\""));
  CHECK(refuses("cli/commands/a.cpp", "#include <CLI/CLI.hpp>"));
  CHECK(refuses("stray/a.cpp", ""));
  CHECK(refuses("cli/a.cpp", std::string(500, '\n')));
}

TEST_CASE("the check of includes lets through what the architecture allows") {
  CHECK_FALSE(refuses("common/a.h", "#include \"common/b.h\"\n#include <vector>"));
  CHECK_FALSE(refuses("common/trace/bvh/a.h", "#include \"common/trace/sphere.h\""));
  CHECK_FALSE(refuses("common/trace/tracer.cpp", "#include \"common/trace/reference/octree.h\""));
  CHECK_FALSE(refuses("common/trace/selfcheck/a.h", "#include \"common/trace/tracer.h\""));
  CHECK_FALSE(refuses("proto/a.h", "#include \"common/b.h\"\n#include <chrono>"));
  CHECK_FALSE(refuses("worker/a.cpp", "#include \"proto/link.h\"\n#include <thread>"));
  CHECK_FALSE(
      refuses("cli/a.cpp", "#include \"coordinator/jobs/job.h\"\n#include \"worker/team.h\""));
  CHECK_FALSE(refuses("cli/output/picture/image_codec.cpp", "#include <OpenImageIO/imageio.h>"));
  CHECK_FALSE(refuses("cli/output/picture/exr_codec.cpp", "#include <OpenEXR/ImfHeader.h>"));
  CHECK_FALSE(
      refuses("cli/input/particles/a.cpp", "#include \"cli/input/scene_file/json_value.h\""));
  CHECK_FALSE(refuses("cli/check/compare/a.h", "#include \"common/image/image.h\""));
  CHECK_FALSE(refuses("cli/a.cpp", "#include \"cli/input/particles/selected_particles.h\""));
  CHECK_FALSE(refuses("cli/input/formats/gemmi_seam.cpp", "#include <gemmi/pdb.hpp>"));
  CHECK_FALSE(refuses("common/a.h", "// the text #include \"proto/link.h\" in a comment"));
  CHECK_FALSE(refuses("cli/a.cpp", std::string(499, '\n')));
}

}  // namespace parray
