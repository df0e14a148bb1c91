#pragma once

#include <concepts>
#include <cstddef>
#include <vector>

#include "common/trace/capsule.h"
#include "common/trace/inside_stack.h"
#include "common/trace/ray.h"
#include "common/trace/sphere.h"

namespace parray::trace {

/// Finds the first sphere that a ray enters. Immutable, so any number of threads may use it.
///
/// `enter` replaces `best` by the nearest sphere that the ray enters, if it is nearer than `best`
/// and not excluded by sides.cannot_enter(). All searches call enters() of sphere.h on the same
/// numbers and break ties by index, so all give the same bits. A search may also have a function
/// `enter_capsules` with the same parameters, which finds capsules.
template <typename S, typename Real, typename Sides>
concept EntrySearch = requires(const S& s, const Ray<Real>& ray, const Sides& sides,
                               Hit<Real>& best) {
  { s.enter(ray, sides, best) } -> std::same_as<void>;
};

/// A search that is built from the spheres in input order.
template <typename S, typename Real>
concept SphereSearch = EntrySearch<S, Real, InsideStack<Real>> && std::constructible_from < S,
        const std::vector<SphereShape<Real>>
& > &&requires(const S& s) {
  { s.bytes() } -> std::same_as<std::size_t>;
};

/// Replaces `best` by the sphere or capsule number `index` if the ray enters it nearer, and may
/// enter it: the step that all searches share.
template <typename Real, typename Shape, typename List>
void try_shape(const Ray<Real>& ray, const Shape& shape, std::uint32_t index,
               const InsideStack<Real, List>& sides, Hit<Real>& best) {
  Real t;
  if (enters(ray, shape, t) && best.loses_to(t, index) && !sides.cannot_enter(index)) {
    best = {t, index, false};
  }
}

}  // namespace parray::trace
