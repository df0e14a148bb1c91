#pragma once

#include <vector>

#include "common/image/image.h"

/// FLIP: how large a difference a person sees who flips between two pictures on a screen.
///
/// Sources: Andersson, Nilsson, Akenine-Moeller, Oskarsson, Astrom and Fairchild, "FLIP: A
/// Difference Evaluator for Alternating Images", 2020; for high dynamic range Andersson, Nilsson,
/// Shirley and Akenine-Moeller, "Visualizing Errors in Rendered High Dynamic Range Images", 2021.
/// The observer sees 67 pixels a degree: a screen 0.7 m wide, of 3840 pixels, from 0.7 m.
///
/// Both functions take linear RGB of two pictures of the same size. A map has one value a pixel,
/// row by row, in [0, 1]; 0 where nothing differs within some 10 pixels. Where a pixel is not
/// finite in one of the pictures it is NaN, and for its neighbours it is black in both. Swapping
/// the pictures leaves flip() as it is, but not hdr_flip(), whose exposures are the reference's.
namespace parray::compare {

using FlipMap = std::vector<float>;

/// Pictures as a screen shows them, clamped to [0, 1]. (FLIP's first step undoes the sRGB curve;
/// linear RGB is what it arrives at.)
FlipMap flip(const Image& reference, const Image& image);

struct HdrFlip {
  FlipMap map;
  double start_exposure = 0;  ///< in stops
  double stop_exposure = 0;
  int exposures = 0;  ///< evenly spaced from start to stop, 2 or more
};

/// The largest flip() of the pictures as photographed at several exposures: from the one that
/// brings the reference's brightest pixel to 0.85 of the tone mapper's (ACES) white to the one that
/// does so for its median pixel. Negative values count as 0.
HdrFlip hdr_flip(const Image& reference, const Image& image);

/// Mean of the map without its NaN; NaN if there is nothing else.
double mean_of(const FlipMap& map);

}  // namespace parray::compare
