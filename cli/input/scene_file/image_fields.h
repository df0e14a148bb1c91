#pragma once

#include "cli/input/scene_file/scene_fields.h"
#include "common/scene/settings_fields.h"

namespace parray::input {

/// Describes the members of the sections `image` and `render` of a scene file: calls `f`, a visitor
/// as in settings_fields.h, for the settings of a picture and for the boolean `transparent`. The
/// traits `image` and `render` of a member tell its section. The visitor must skip members with
/// neither trait. Callers without a value for `transparent` leave out that argument.
template <typename F, typename S, typename... T>
void image_fields(F&& f, S& settings, T&... transparent) {
  stop_fields(f, settings);
  picture_fields(f, settings);
  f({"transparent", nullptr, traits::image}, Flag{}, transparent...);
}

}  // namespace parray::input
