#pragma once

#include <concepts>
#include <cstddef>
#include <vector>

#include "common/trace/capsule.h"
#include "common/trace/inside_stack.h"
#include "common/trace/ray.h"
#include "common/trace/sphere.h"

namespace parray::trace {

/// Finds the first sphere that a ray enters. A search is built from the spheres in input order and
/// is immutable afterwards, so any number of threads may use it.
///
/// `enter` improves `best` with the nearest sphere that the ray enters and that `sides` does not
/// exclude. All searches call enters() of sphere.h on the same numbers and break ties by index, so
/// all give the same bits.
template <typename S, typename Real>
concept SphereSearch = std::constructible_from < S,
        const std::vector<SphereShape<Real>>
& > &&requires(const S& s, const Ray<Real>& ray, const InsideStack<Real>& sides, Hit<Real>& best) {
  { s.enter(ray, sides, best) } -> std::same_as<void>;
  { s.bytes() } -> std::same_as<std::size_t>;
};

/// Tries one sphere or capsule: the step that all searches share.
template <typename Real, typename Shape>
void try_shape(const Ray<Real>& ray, const Shape& shape, std::uint32_t index,
               const InsideStack<Real>& sides, Hit<Real>& best) {
  Real t;
  if (enters(ray, shape, t) && best.loses_to(t, index) && !sides.cannot_enter(index)) {
    best = {t, index, false};
  }
}

}  // namespace parray::trace
