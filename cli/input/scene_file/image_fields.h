#pragma once

#include "cli/input/scene_file/scene_fields.h"
#include "common/scene/settings_fields.h"

namespace parray::input {

/// Calls the visitor `f` for the settings of a picture and for `transparent`. The visitor is that
/// of settings_fields.h. The traits `image` and `render` tell to which section of a scene file a
/// member belongs. Members with neither trait are in no section: the visitor must skip them.
/// `transparent`: a boolean, or nothing.
template <typename F, typename S, typename... T>
void image_fields(F&& f, S& settings, T&... transparent) {
  stop_fields(f, settings);
  picture_fields(f, settings);
  f({"transparent", nullptr, traits::image}, Flag{}, transparent...);
}

}  // namespace parray::input
