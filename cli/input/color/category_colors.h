#pragma once

#include <cstddef>
#include <string_view>

#include "common/math/vec.h"

namespace parray::input {

/// So many colours are distinct; then they come again.
inline constexpr std::size_t category_color_count = 24;

/// Linear RGB of a category by its number. Those of the first seven are Okabe and Ito's ("Color
/// Universal Design", 2008; black is left out because a black ball shows no shape). Each that
/// follows is the one of a grid in sRGB that lies farthest, in Oklab, from all before it and from
/// the grey of what is unknown, as seen by the nearest of four observers: one with normal colour
/// vision and Machado, Oliveira and Fernandes's protanope, deuteranope and tritanope ("A
/// physiologically-based model for simulation of color vision deficiency", IEEE TVCG 15(6), 2009).
Vec3d category_color(std::size_t number);

/// Of what belongs to no category: a grey.
inline constexpr Vec3d no_category_color{0.5, 0.5, 0.5};

}  // namespace parray::input
