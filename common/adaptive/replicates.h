#pragma once

#include "common/image/framebuffer.h"
#include "common/image/picture_bytes.h"

namespace parray::adaptive {

/// Returns the two replicates of a picture (common/image/picture_bytes.h). If a pixel has a single
/// sample, both halves contain it. If any pixel has fewer than two samples, the noise of all pixels
/// is 0, which here means unknown. Non-finite samples count as black. The result has the same bits
/// on every machine.
Replicates replicates_of(const FramebufferView& state);

}  // namespace parray::adaptive
