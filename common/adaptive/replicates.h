#pragma once

#include "common/image/framebuffer.h"
#include "common/image/replicates.h"

namespace parray::adaptive {

/// Returns the two halves of a picture's samples. A pixel with a single sample has it in both
/// halves, and then the noise of the whole picture is unknown: 0. Non-finite samples count as
/// black. The result has the same bits on every machine.
Replicates replicates_of(const FramebufferView& state);

}  // namespace parray::adaptive
