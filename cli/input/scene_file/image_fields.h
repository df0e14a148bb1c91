#pragma once

#include "cli/input/scene_file/scene_fields.h"
#include "common/scene/settings_fields.h"

namespace parray::input {

/// Sections `image` and `render`: settings, and whether the picture is transparent.
template <typename F, typename S, typename... T>
void image_fields(F&& f, S& settings, T&... transparent) {
  stop_fields(f, settings);
  picture_fields(f, settings);
  f({"transparent", nullptr, traits::image}, Flag{}, transparent...);
}

}  // namespace parray::input
