#pragma once

#include "common/scene/scene.h"

namespace parray::scene {

/// Returns the point, in the scene's coordinates, from which kernels measure positions.
///
/// Positions are double until they are taken relative to this point. Only then are they rounded to
/// the precision of the kernel. The point is 0 or the medians of the coordinates of the shapes'
/// centres. It is the medians only if the camera and half of the shapes are then at least four
/// times nearer. That is the case in a scene whose coordinates are large only because the scene
/// lies far from 0. (For an orthographic camera only look_from counts. Another origin does not
/// change the distance between look_from and the starts of its rays.) The result depends on the
/// scene alone, not on the order of its shapes or on `threads`, the number of threads to use. The
/// time is proportional to the number of shapes.
Vec3d scene_origin(const Scene& scene, int threads = 1);

}  // namespace parray::scene
