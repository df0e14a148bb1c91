#pragma once

#include "cli/input/scene_file/scene_fields.h"
#include "common/scene/settings_fields.h"

namespace parray::input {

/// Visits the members of the sections `image` and `render`: settings, as settings_fields.h
/// describes them, and `transparent`. The traits `image` and `render` tell to which section a
/// member belongs. Settings with neither trait are in no section.
template <typename F, typename S, typename... T>
void image_fields(F&& f, S& settings, T&... transparent) {
  stop_fields(f, settings);
  picture_fields(f, settings);
  f({"transparent", nullptr, traits::image}, Flag{}, transparent...);
}

}  // namespace parray::input
