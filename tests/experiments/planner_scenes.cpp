// Scenes over the extremes of what a scene file may hold, for tests/experiments/planner and asked:
// planner_scenes DIR COUNT [SEED].
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iostream>
#include <string>

#include "cli/input/scene_file/scene_file.h"
#include "tests/support/extreme_scenes.h"
#include "tests/support/rooms.h"

int main(int argc, char** argv) {
  if (argc != 3 && argc != 4) {
    std::cerr << "usage: planner_scenes DIR COUNT [SEED]\n";
    return 2;
  }
  const std::uint64_t seed = argc == 4 ? std::strtoull(argv[3], nullptr, 10) : 20261121;
  const parray::test::ExtremeScenes scenes(seed);
  for (std::uint64_t i = 0; i < std::strtoull(argv[2], nullptr, 10); ++i) {
    const parray::test::ExtremeScene made = scenes.make(i);
    parray::input::SceneFile file;
    file.scene = made.scene;
    std::string name = made.kind + ".json";
    for (char& c : name) c = c == ' ' ? '-' : c;
    std::ofstream out(std::filesystem::path(argv[1]) / name);
    parray::input::write_scene(out, file, [] {});
  }
  return 0;
}
