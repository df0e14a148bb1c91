#pragma once

#include <vector>

#include "common/image/image.h"

/// FLIP: the difference that a viewer sees when flipping between two pictures on a screen.
///
/// Sources: Andersson, Nilsson, Akenine-Moeller, Oskarsson, Astrom and Fairchild, "FLIP: A
/// Difference Evaluator for Alternating Images", 2020; for high dynamic range Andersson, Nilsson,
/// Shirley and Akenine-Moeller, "Visualizing Errors in Rendered High Dynamic Range Images", 2021.
/// The observer sees 67 pixels a degree: a screen 0.7 m wide, of 3840 pixels, from 0.7 m.
///
/// Both functions take linear RGB of two pictures of the same size. A map has one value per pixel
/// in [0, 1], row by row. The value is 0 if nothing differs within about 10 pixels. It is NaN for a
/// pixel that is not finite in one of the pictures; neighbours see that pixel as black in both.
/// flip() is symmetric. hdr_flip() is not: its exposures come from the reference.
namespace parray::compare {

using FlipMap = std::vector<float>;

/// Compares the pictures as a screen shows them, clamped to [0, 1]. FLIP's first step, undoing the
/// sRGB curve, is left out, because the input is linear RGB.
FlipMap flip(const Image& reference, const Image& image);

struct HdrFlip {
  FlipMap map;
  double start_exposure = 0;  ///< in stops: multiplies the values by 2 to this power
  double stop_exposure = 0;   ///< in stops, not below start_exposure
  int exposures = 0;          ///< evenly spaced from start to stop, one per stop; 2 or more
};

/// Returns each pixel's largest flip() over several exposures, each after tone mapping (ACES). The
/// first exposure brings the reference's brightest pixel to 0.85 of the tone mapper's white, the
/// last one its median pixel. Negative values count as 0.
HdrFlip hdr_flip(const Image& reference, const Image& image);

/// Returns the mean of the values that are not NaN, or NaN if there are none.
double mean_of(const FlipMap& map);

}  // namespace parray::compare
