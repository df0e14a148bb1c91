#include <filesystem>
#include <fstream>
#include <sstream>

#include "cli/input/scene_file/scene_file.h"
#include "common/base/error.h"
#include "tests/fuzz/target.h"
#include "tests/support/rooms.h"

namespace parray::fuzz {
namespace {

namespace fs = std::filesystem;

SceneFile read(std::string_view text) {
  std::istringstream in{std::string(text)};
  return read_scene(in, "s.json");
}

std::string written(const SceneFile& file) {
  std::ostringstream out;
  write_scene(out, file, [] {});
  return out.str();
}

/// What is read can be written, and is read again as what it was.
void promise_writable(const SceneFile& file) {
  const std::string text = written(file);
  try {
    const SceneFile again = read(text);
    promise(again.scene == file.scene && again.settings == file.settings, "a scene as written");
    promise(again.duplicates.count == 0, "duplicates are left out once");
    promise(written(again) == text, "the same text again");
  } catch (const InputError& error) {
    throw Violation(std::string("a scene that we have written is refused: ") + error.what());
  }
}

bool run(std::string_view input) {
  SceneFile file;
  try {
    file = read(input);
  } catch (const InputError& error) {
    promise_one_line(error.what());
    promise(std::string_view(error.what()).starts_with("s.json:"), "an error that names the file");
    return false;
  }
  promise_usable(file.scene, file.settings);
  promise_writable(file);
  return true;
}

std::string text_of(const fs::path& path) {
  std::ostringstream text;
  text << std::ifstream(path, std::ios::binary).rdbuf();
  return text.str();
}

/// The small scenes that ship; the seed program's format, and references to particles.
std::vector<std::string> seeds() {
  const fs::path scenes = PARRAY_SOURCE_DIR "/scenes";
  std::vector<std::string> texts;
  for (const char* name : {"glass", "shells", "cavity", "one-weekend-8", "regression/contact",
                           "regression/earth", "regression/tiny-far-huge"}) {
    texts.push_back(text_of(scenes / (std::string(name) + ".json")));
  }
  texts.push_back(R"({"spheres": [
  {"sphere": {"location": {"x": 0, "y": 1, "z": 2}, "radius": 0.1,
    "material": {"type": "lambertian", "color": {"r": 0.1, "g": 0.2, "b": 0.3}}}},
  {"sphere": {"location": {"x": 3, "y": 1, "z": -2}, "radius": 1,
    "material": {"type": "metal", "color": {"r": 1, "g": 0, "b": 0.3}, "fuzz": 0.5}}},
  {"sphere": {"radius": 1.0, "location": {"x": 1, "y": 2, "z": 3},
    "material": {"type": "dielectric", "refraction_index": 1.5}}}]})");
  texts.push_back(R"({"version": 1,
  "camera": {"look_from": [0, 0, 9], "look_at": [0, 0, 0], "up": [0, 1, 0], "vfov": 40,
    "aperture": 0.5, "focus_distance": 9},
  "image": {"width": 64, "height": 48},
  "render": {"samples_per_pixel": 16, "max_depth": 8, "seed": 18446744073709551615},
  "sky": {"horizon": [1, 1, 1], "zenith": [0, 0, 1e3]},
  "materials": {"\u00e9\n": {"type": "metal", "albedo": [1, 0, 1], "fuzz": 0.5}},
  "particles": [{"file": "a.xyz", "material": "by-element", "radius": "column"},
    {"file": "../c.csv", "material": "\u00e9\n", "radius": 0.1},
    {"file": "d.pdb", "select": "chain A and z > 1", "hide": ["water"], "slice": "z=40%:60%",
      "color_by": "b_factor", "colormap": "magma", "range": [0, 90]}]})");
  texts.push_back(R"({"version": 1,
  "camera": {"look_from": [0, 0, 9], "look_at": [0, 0, 0], "projection": "orthographic",
    "view_height": 3, "aperture": 0.5},
  "image": {"width": 9, "height": 5, "transparent": true}, "style": "flat",
  "finishing": {"outline": "0.5pt", "depth_cue": true},
  "materials": {"a": {"type": "dielectric", "ior": 1.5}},
  "spheres": [{"center": [0, 0, 9], "radius": 1, "material": "a"}]})");
  return texts;
}

}  // namespace

const Target scene_target{"scene", run, seeds};

}  // namespace parray::fuzz
