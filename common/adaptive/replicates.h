#pragma once

#include "common/image/framebuffer.h"
#include "common/image/replicates.h"

namespace parray::adaptive {

/// The halves of a picture. Where a pixel has a single sample both are that, and the noise of the
/// whole picture is not known: 0. Samples that were not finite count as black. In arithmetic that
/// is the same everywhere.
Replicates replicates_of(const FramebufferView& state);

}  // namespace parray::adaptive
