#pragma once

#include "common/scene/scene.h"

namespace parray::scene {

/// The point that kernels measure positions from, in the scene's coordinates.
///
/// Positions are double until they are taken relative to this point; only then are they rounded to
/// the precision of the kernel. It is 0 unless another point brings the camera and most spheres at
/// least four times nearer: scenes whose coordinates are large for no reason but where they happen
/// to lie. (Of an orthographic camera look_from counts, not how far around it its rays begin:
/// another origin brings that no nearer, and no farther.) A function of the scene alone, whatever
/// the order of its spheres and the number of threads; takes time in proportion to their number.
Vec3d scene_origin(const Scene& scene, int threads = 1);

}  // namespace parray::scene
