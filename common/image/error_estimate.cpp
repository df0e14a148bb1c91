#include "common/image/error_estimate.h"
namespace parray {
ErrorEstimate estimate_error(const PictureState& state) {
  ErrorEstimate e;
  e.half_width.resize(state.pixels.size() * 3);
  return e;
}
}  // namespace parray
