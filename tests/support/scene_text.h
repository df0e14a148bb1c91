#pragma once

#include <sstream>
#include <string>

#include "cli/input/scene_file/scene_file.h"
#include "common/base/error.h"
#include "tests/support/message_of.h"
#include "tests/support/rooms.h"

namespace parray::test {

/// Reads a scene of this text. Messages call its file s.json.
inline SceneFile read_scene_text(const std::string& text) {
  std::istringstream in(text);
  return read_scene(in, "s.json");
}

/// Returns the message with which a scene of this text is refused, or "no error".
inline std::string message_of_scene(const std::string& text) {
  return message_of<InputError>([&] { (void)read_scene_text(text); });
}

}  // namespace parray::test
