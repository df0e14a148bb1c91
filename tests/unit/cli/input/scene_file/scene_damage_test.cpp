#include <doctest/doctest.h>
#include <unistd.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <random>
#include <sstream>
#include <string>
#include <vector>

#include "cli/input/scene_file/scene_file.h"
#include "common/base/error.h"
#include "common/scene/limits.h"
#include "tests/support/message_of.h"
#include "tests/support/rooms.h"
#include "tests/support/scene_text.h"

namespace parray {
namespace {

using test::message_of;
using test::message_of_scene;

namespace fs = std::filesystem;

/// A scene whose every line has something to break.
std::string valid_scene() {
  return R"({
  "version": 1,
  "camera": {
    "look_from": [13, 2, 3],
    "look_at": [0, 0, 0],
    "vfov": 20
  },
  "materials": {
    "gold": {"type": "metal", "albedo": [0.8, 0.6, 0.2], "fuzz": 0.1},
    "glass": {"type": "dielectric", "ior": 1.5}
  },
  "spheres": [
    {"center": [0, 1, 0], "radius": 1, "material": "gold"},
    {"center": [4, 1, 0], "radius": 1, "material": "glass"}
  ]
}
)";
}

std::string message_of_file(const fs::path& path) {
  return message_of<InputError>([&] { (void)read_scene_file(path); });
}

/// The valid scene with its first `from` replaced.
std::string with(const std::string& from, const std::string& to) {
  std::string text = valid_scene();
  const std::size_t place = text.find(from);
  REQUIRE(place != std::string::npos);
  return text.replace(place, from.size(), to);
}

struct Damage {
  std::string name;
  std::string scene;
  std::string message;  ///< exact
};

void check_all(const std::vector<Damage>& table) {
  for (const Damage& damage : table) {
    CAPTURE(damage.name);
    CHECK(message_of_scene(damage.scene) == damage.message);
  }
}

/// A folder of its own that goes with the test.
class ScratchFolder {
 public:
  ScratchFolder()
      : path_(fs::temp_directory_path() / ("parray-scene-" + std::to_string(::getpid()))) {
    fs::create_directories(path_);
  }
  ~ScratchFolder() {
    std::error_code ignored;
    fs::remove_all(path_, ignored);
  }
  ScratchFolder& operator=(ScratchFolder&&) = delete;

  fs::path write(const std::string& name, const std::string& text) const {
    std::ofstream(path_ / name, std::ios::binary) << text;
    return path_ / name;
  }
  const fs::path& path() const { return path_; }

 private:
  fs::path path_;
};

}  // namespace

TEST_CASE("the scene before damage is valid") {
  CHECK(message_of_scene(valid_scene()) == "no error");
}

TEST_CASE("text that is not JSON is refused with the line and a remedy") {
  check_all({
      {"empty", "", "s.json:1: /: the file ends before a JSON object begins: write a JSON object"},
      {"blank", " \n\n ",
       "s.json:3: /: the file ends before a JSON object begins: write a JSON object"},
      {"not JSON", "\x89PNG\r\n",
       "s.json:1: /: the text is not JSON (invalid literal at '\\x89'): write a number such as 0.5 "
       "or 1e3, or a string in double quotes"},
      {"a name without quotes", with("\"vfov\"", "vfov"),
       "s.json:6: /camera/look_at: the text is not JSON (invalid literal at 'v'): write a number "
       "such as 0.5 or 1e3, or a string in double quotes"},
      {"a comma missing", with("[13, 2, 3],", "[13, 2, 3]"),
       "s.json:5: /camera/look_from: the text is not JSON (unexpected string literal; expected "
       "'}'): look for "
       "a missing quote, comma or bracket"},
      {"a comma too many", with("\"vfov\": 20", "\"vfov\": 20,"),
       "s.json:7: /camera/vfov: the text is not JSON (unexpected '}'; expected string literal): "
       "remove the comma before the bracket, or write what is missing"},
      {"a value missing", with("\"vfov\": 20", "\"vfov\": "),
       "s.json:7: /camera/vfov: the text is not JSON (unexpected '}'; expected '[', '{', or a "
       "literal): remove the comma before the bracket, or write what is missing"},
      {"a list that is not closed", with("[13, 2, 3],", "[13, 2, 3}"),
       "s.json:4: /camera/look_from/3: the text is not JSON (unexpected '}'; expected ']'): close "
       "the list with ]"},
      {"an object that is not closed", with("\"vfov\": 20", "\"vfov\": 20]"),
       "s.json:6: /camera/vfov: the text is not JSON (unexpected ']'; expected '}'): close the "
       "object with }"},
      {"a key without quotes that begins as Infinity does", with("\"version\"", "image"),
       "s.json:2: /: the text is not JSON (invalid literal at 'i'): JSON has no NaN or Infinity; "
       "write finite numbers, and words in double quotes"},
      {"a comment", with("  \"version\"", "  // about\n  \"version\""),
       "s.json:2: /: the text is not JSON (invalid literal at '/'): JSON has no comments; remove "
       "them"},
      {"single quotes", with("\"gold\"", "'gold'"),
       "s.json:9: /materials: the text is not JSON (invalid literal at '''): write strings in "
       "double quotes"},
      {"text after the end", valid_scene() + "x",
       "s.json:17: /: text follows the end of the JSON object: remove it"},
      {"a second scene", valid_scene() + valid_scene(),
       "s.json:17: /: text follows the end of the JSON object: remove it"},
      {"truncated in a string", valid_scene().substr(0, 5),
       "s.json:2: /: the file ends within the JSON object: check that the file is complete"},
      {"truncated in a number", valid_scene().substr(0, valid_scene().find("13") + 1),
       "s.json:4: /camera/look_from/1: the file ends within the JSON object: check that the "
       "file is complete"},
      {"truncated at the end", valid_scene().substr(0, valid_scene().size() - 2),
       "s.json:15: /spheres: the file ends within the JSON object: check that the file is "
       "complete"},
      {"a zero byte", with("20", std::string("2\0", 2)),
       "s.json:6: /: the text contains a NUL byte: save the file as UTF-8"},
      {"zero bytes after the end", valid_scene() + std::string(3, '\0'),
       "s.json:17: /: the text contains a NUL byte: save the file as UTF-8"},
      {"half a byte order mark", "\xEF\xBB" + valid_scene(),
       "s.json:1: /: the text is not JSON (invalid BOM; must be 0xEF 0xBB 0xBF if given at "
       "'\\xef\\xbb{'): "
       "look for a missing quote, comma or bracket"},
      {"UTF-16", "\xFF\xFE" + with("\"gold\"", "\"gold\""),
       "s.json:1: /: the text is not JSON (invalid literal at '\\xff'): the text looks like "
       "UTF-16; save the file as UTF-8"},
      {"not UTF-8", with("\"gold\": {", "\"g\xFFld\": {"),
       "s.json:9: /materials: the text is not JSON (invalid string: ill-formed UTF-8 byte at "
       "'\"g\\xff'): save "
       "the file as UTF-8"},
      {"a control character in a string", with("\"gold\": {", "\"g\x1bld\": {"),
       "s.json:9: /materials: the text is not JSON (invalid string: control character U+001B (ESC) "
       "must be "
       "escaped to \\u001B at '\"g<U+001B>'): look for a missing quote, comma or bracket"},
  });
}

TEST_CASE("a byte order mark is skipped") {
  CHECK(message_of_scene("\xEF\xBB\xBF" + valid_scene()) == "no error");
}

TEST_CASE("numbers that JSON or double precision cannot hold are refused") {
  check_all({
      {"overflow", with("20", "1e999"),
       "s.json:6: /camera/vfov: number 1e999 is too large: use a number below 1e308"},
      {"negative overflow", with("13", "-1e999"),
       "s.json:4: /camera/look_from/0: number -1e999 is too large: use a number below 1e308"},
      {"NaN", with("20", "NaN"),
       "s.json:6: /camera/vfov: the text is not JSON (invalid literal at '\"vfov\": N'): JSON has "
       "no NaN or Infinity; write finite numbers, and words in double quotes"},
      {"-Infinity", with("20", "-Infinity"),
       "s.json:6: /camera/vfov: the text is not JSON (invalid number; expected digit after '-' at "
       "'-I'): JSON has no NaN or Infinity; write finite numbers, and words in double quotes"},
      {"nan", with("20", "nan"),
       "s.json:6: /camera/vfov: the text is not JSON (invalid literal at '\"vfov\": na'): JSON has "
       "no NaN or Infinity; write finite numbers, and words in double quotes"},
      {"underflow to zero", with("\"radius\": 1,", "\"radius\": 1e-999,"),
       "s.json:13: /spheres/0/radius: 0 is out of range: use a number from 1e-15 to 1e+15"},
  });
}

TEST_CASE("a wrong value is refused with its own line, also where the line ends after it") {
  check_all({
      {"a number before a line end", with("20\n", "200\n"),
       "s.json:6: /camera/vfov: 200 is out of range: use a number from 1e-06 to 179.999"},
      {"a number after empty lines", with("20\n", "\n\n200\n\n"),
       "s.json:8: /camera/vfov: 200 is out of range: use a number from 1e-06 to 179.999"},
      {"a string for a number", with("\"radius\": 1,", "\"radius\": \"1\","),
       "s.json:13: /spheres/0/radius: expected a number, found a string: write a number from 1e-15 "
       "to 1e+15"},
      {"a misspelt key", with("\"vfov\"", "\"vfow\""),
       "s.json:6: /camera/vfow: unknown key 'vfow' in /camera: did you mean 'vfov'?"},
      {"a misspelt section", with("\"materials\"", "\"material\""),
       "s.json:8: /material: unknown key 'material' at the top level: did you mean 'materials'?"},
      {"a missing key", with(",\n    \"vfov\": 20", ""),
       "s.json:3: /camera: missing key 'vfov': add a number from 1e-06 to 179.999"},
      {"an unknown material", with("\"material\": \"gold\"", "\"material\": \"glod\""),
       "s.json:13: /spheres/0/material: unknown material 'glod': did you mean 'gold'?"},
      {"an unknown material like no other", with("\"material\": \"gold\"", "\"material\": \"tin\""),
       "s.json:13: /spheres/0/material: unknown material 'tin': define it in /materials"},
      {"a key that a pointer must escape", with("\"glass\": {", "\"a/b~c\": 1, \"glass\": {"),
       "s.json:10: /materials/a~1b~0c: expected an object, found a number: write { ... } with "
       "type, albedo, fuzz, ior"},
  });
}

TEST_CASE("errors that a schema cannot express are refused") {
  check_all({
      {"the camera looks at itself", with("[0, 0, 0]", "[13, 2, 3]"),
       "s.json:3: /camera: look_from and look_at are the same point: move one of them"},
      {"the camera is too near", with("[0, 0, 0]", "[13, 2, 3.0000000000000004]"),
       "s.json:3: /camera: look_from and look_at are 4.440892098500626e-16 apart: use a distance "
       "between 1e-15 and 1e+15"},
      {"up is parallel to the view", with("\"vfov\"", "\"up\": [-26, -4, -6], \"vfov\""),
       "s.json:3: /camera: up is parallel to the view from look_from to look_at: turn one of them"},
      {"too many pixels",
       with("\"materials\"", "\"image\": {\"width\": 8193, \"height\": 8192},\n \"materials\""),
       "s.json:8: /image: image of 8193 x 8192 pixels is too large: use at most 67108864 pixels"},
      {"an integer too large to be exact with a point",
       with("\"materials\"", "\"render\": {\"seed\": 9007199254740994.0},\n \"materials\""),
       "s.json:8: /render/seed: 9007199254740994 is out of range: use a whole number from 0 to "
       "18446744073709551615"},
      {"the ends of a capsule are too near",
       with(
           "\"spheres\"",
           R"("capsules": [{"from": [0, 0, 0], "to": [0, 0, 1e-15], "radius": 1, "material": "gold"}],
  "spheres")"),
       "s.json:12: /capsules/0/to: the ends of the capsule are less than 2e-15 apart: write equal "
       "ends, or use a smaller unit of length"},
      {"a capsule of an unknown material",
       with("\"spheres\"",
            R"("capsules": [{"from": [0, 0, 0], "to": [0, 0, 1], "radius": 1, "material": "glod"}],
  "spheres")"),
       "s.json:12: /capsules/0/material: unknown material 'glod': did you mean 'gold'?"},
      {"a section twice", with("  \"spheres\"", "  \"version\": 1,\n  \"spheres\""),
       "s.json:12: /version: duplicate key 'version': remove one of them"},
      {"a key twice", with("\"vfov\": 20", "\"vfov\": 20,\n\"vfov\": 20"),
       "s.json:7: /camera/vfov: duplicate key 'vfov': remove one of them"},
      {"a material twice", with("\"glass\": {", "\"gold\": {"),
       "s.json:10: /materials/gold: duplicate key 'gold': remove one of them"},
      {"version 1 among spheres of the seed's format",
       R"({"spheres": [{"sphere": {"location": {"x": 0, "y": 0, "z": 0}, "radius": 1,
           "material": {"type": "dielectric", "refraction_index": 1.5}}}], "version": 1})",
       "s.json:2: /version: this key belongs to scene JSON version 1, but the spheres have the "
       "seed format ({\"sphere\": ...}): write spheres as {\"center\": [X, Y, Z], "
       "\"radius\": R, \"material\": NAME}"},
  });
}

TEST_CASE("damage in the seed format is refused") {
  const auto seed = [](const std::string& material) {
    return "{\"spheres\": [\n{\"sphere\": {\"location\": {\"x\": 0, \"y\": 0, \"z\": 0},\n"
           "\"radius\": 1, \"material\": " +
           material + "}}]}";
  };
  CHECK(message_of_scene(seed(R"({"type": "dielectric", "refraction_index": 1.5})")) == "no error");
  check_all({
      {"an unknown type", seed(R"({"type": "lambertain"})"),
       "s.json:3: /spheres/0/sphere/material/type: unknown material type 'lambertain': did you "
       "mean 'lambertian'?"},
      {"a version 1 type", seed(R"({"type": "diffuse"})"),
       "s.json:3: /spheres/0/sphere/material/type: unknown material type 'diffuse': known: "
       "lambertian, metal, dielectric"},
      {"no colour", seed(R"({"type": "metal", "fuzz": 0})"),
       "s.json:3: /spheres/0/sphere/material: missing key 'color': add { ... } with r, g, b"},
      {"half a colour", seed(R"({"type": "lambertian", "color": {"r": 0, "g": 0}})"),
       "s.json:3: /spheres/0/sphere/material/color: missing key 'b': add a number from 0 to 1"},
      {"fuzz of another type", seed(R"({"type": "dielectric", "refraction_index": 1, "fuzz": 0})"),
       "s.json:3: /spheres/0/sphere/material/fuzz: unknown key 'fuzz' in "
       "/spheres/0/sphere/material: known: type, refraction_index"},
      {"a bright colour", seed(R"({"type": "lambertian", "color": {"r": 0, "g": 2, "b": 0}})"),
       "s.json:3: /spheres/0/sphere/material/color/g: 2 is out of range: use a number from 0 to 1"},
  });
}

TEST_CASE("the reader limits nesting, lengths and numbers of values") {
  const std::string mega(std::size_t{3} << 20, 'x');
  check_all({
      {"deep at the top", std::string(1'000'000, '['),
       "s.json:1: /: expected an object, found an array: check that this is the right file"},
      {"deep in a sphere", "{\"spheres\": [" + std::string(1'000'000, '['),
       "s.json:1: /spheres/0/0/0/0/0/0/0/0/0/0/0/0/0/0/0: values are nested deeper than 16 levels: "
       "remove levels"},
      {"wide in a section", with("[13, 2, 3]", "[" + std::string(600, '[')),
       "s.json:4: /camera/look_from/0/0/0/0/0/0/0/0/0/0/0/0/0/0: values are nested deeper than 16 "
       "levels: remove levels"},
      {"a long string", with("\"gold\"", "\"" + mega + "\""),
       "s.json:9: /: a text or a run of blanks is longer than 1048576 bytes: check that this is a "
       "JSON file"},
      {"a long blank", with("  \"version\"", std::string(mega.size(), ' ') + "\"version\""),
       "s.json:2: /: a text or a run of blanks is longer than 1048576 bytes: check that this is a "
       "JSON file"},
  });
  std::string wide = "[0";
  for (int i = 0; i < 5000; ++i) wide += ",0";
  CHECK(message_of_scene(with("[13, 2, 3]", wide + "]")) ==
        "s.json:4: /camera/look_from/4094: one value has more than 4096 parts: remove some");
}

TEST_CASE("a message is one printable line for any content of the file") {
  const std::string key = "\\u001b[2J\\n" + std::string(5000, 'k') + "\\u202e";
  for (const std::string& scene :
       {with("\"vfov\"", "\"" + key + "\""), with("\"version\"", "\"" + key + "\""),
        with("\"gold\"", "\"" + key + "\""), with("\"metal\"", "\"" + key + "\""),
        with("\"material\": \"gold\"", "\"material\": \"" + key + "\"")}) {
    const std::string message = message_of_scene(scene);
    CAPTURE(message);
    CHECK(message != "no error");
    CHECK(message.size() < 400);
    CHECK(std::ranges::all_of(message, [](char c) { return c >= ' ' && c <= '~'; }));
  }
  std::istringstream input("?");
  CHECK_THROWS_WITH_AS(read_scene(input, "a\x1b[2J"),
                       doctest::Contains("a\\x1b[2J:1: /: the text is not JSON"), InputError);
}

TEST_CASE("missing files and directories are refused with their name") {
  const ScratchFolder folder;
  const std::string root = folder.path().string();
  CHECK(message_of_file(folder.path() / "none.json") ==
        root + "/none.json: no such file: check the path");
  CHECK(message_of_file(folder.path() / "a" / "b.json") ==
        root + "/a/b.json: no such file: check the path");
  CHECK(message_of_file(folder.path()) == root + ": is a directory: name a file in it");
  CHECK(message_of_file(folder.write("empty.json", "")) ==
        root + "/empty.json: the file is empty: check that the file is complete");
  CHECK(message_of_file(folder.write("good.json", valid_scene())) == "no error");
  const fs::path below_a_file = folder.path() / "good.json" / "s.json";
  CHECK(message_of_file(below_a_file).starts_with(below_a_file.string() + ": "));
}

TEST_CASE("a file that cannot be read is refused") {
  const ScratchFolder folder;
  const fs::path secret = folder.write("secret.json", valid_scene());
  fs::permissions(secret, fs::perms::none);
  if (::geteuid() != 0) {  // permissions do not stop root
    CHECK(message_of_file(secret) == secret.string() +
                                         ": cannot be opened (Permission denied): check its "
                                         "permissions");
  }
  // A file of the kernel whose first bytes cannot be read.
  if (fs::exists("/proc/self/mem")) {
    CHECK(message_of_file("/proc/self/mem") ==
          "/proc/self/mem: reading failed (Input/output error): check the disk");
  }
}

TEST_CASE("a file beyond the size limit is refused before it is read") {
  const ScratchFolder folder;
  const fs::path path = folder.write("huge.json", valid_scene());
  std::error_code error;
  fs::resize_file(path, limits::max_scene_file_bytes + 1, error);  // a hole: takes no space
  if (error) return;                                               // not on this file system
  CHECK(message_of_file(path) ==
        path.string() + ": the file has 17179869185 bytes, more than 17179869184: split it");
}

TEST_CASE("a randomly damaged scene loads or is refused, and nothing else") {
  int loaded = 0;
  int refused = 0;
  for (unsigned seed = 0; seed < 2000; ++seed) {
    std::mt19937 random(seed);
    std::string text = valid_scene();
    const auto below = [&](std::size_t end) { return static_cast<std::size_t>(random()) % end; };
    for (std::size_t damage = below(4) + 1; damage > 0 && !text.empty(); --damage) {
      const std::size_t place = below(text.size());
      switch (below(5)) {
        case 0: text[place] = static_cast<char>(text[place] ^ (1 << below(8))); break;
        case 1: text.erase(place, below(12) + 1); break;
        case 2: text.insert(place, 1, static_cast<char>(below(256))); break;
        case 3: text.insert(place, text.substr(below(text.size()), below(40))); break;
        default: text.resize(place == 0 || below(4) != 0 ? text.size() : place); break;
      }
    }
    CAPTURE(seed);
    const std::string message = message_of_scene(text);  // lets everything but InputError through
    ++(message == "no error" ? loaded : refused);
    if (message != "no error") CHECK(message.starts_with("s.json:"));
  }
  CHECK(loaded > 20);  // the damage is mild enough to reach the decoders
  CHECK(refused > 1000);
}

}  // namespace parray
