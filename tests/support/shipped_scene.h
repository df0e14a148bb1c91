#pragma once

#include <string>

#include "cli/input/scene_file/scene_file.h"
#include "tests/support/rooms.h"

namespace parray::test {

/// Returns a file of the folder scenes/ of the sources.
inline SceneFile shipped(const std::string& name) {
  return read_scene_file(std::string(PARRAY_SOURCE_DIR) + "/scenes/" + name);
}

}  // namespace parray::test
