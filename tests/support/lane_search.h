#pragma once

#include <cstdint>
#include <cstring>
#include <memory>
#include <span>
#include <stdexcept>
#include <vector>

#include "common/scene/settings.h"
#include "common/trace/bvh/wide_bvh.h"
#include "common/trace/integrator/isa_kernels.h"
#include "common/trace/isa.h"
#include "tests/support/ray_queries.h"
#include "tests/support/rooms.h"

/// The search of the lane kernels for tests: spheres by input index, many rays at once.
namespace parray::test {

/// A precision: the type of path computations and the type of stored spheres.
struct SinglePrecision {
  using Real = float;
  using Store = float;
};
struct MixedPrecision {
  using Real = double;
  using Store = float;
};
struct DoublePrecision {
  using Real = double;
  using Store = double;
};

/// Finds the next hits of paths.
template <typename Real>
class LaneSearch {
 public:
  virtual ~LaneSearch() = default;
  /// Returns the hit of each query. Takes at most SampleBatch::most queries; the kernel traces
  /// their paths together. `beam`: so many neighbouring queries are alike, stand on no surface and
  /// are inside no sphere; 0: none are.
  virtual std::vector<Hit<Real>> find(std::span<const Query<Real>> queries,
                                      std::uint32_t beam = 0) = 0;
  [[nodiscard]] virtual std::uint32_t depth() const = 0;
};

template <typename Real, typename Store, int W>
class LaneSearchOf final : public LaneSearch<Real> {
 public:
  using Scene = KernelScene<Real, Store, W>;
  using Space = Workspace<Real, Store>;
  using Find = void (*)(const Scene&, Space&);

  LaneSearchOf(Find function, const Spheres<Store>& spheres, bool tree, bool sides)
      : function_(function),
        tables_(spheres, tree, 1),
        scene_(CameraRays<Real>(Camera{}, 1, 1), SkyGradient<Real>(Sky{})),
        space_(std::make_unique<Space>()),
        slot_of_(spheres.size()) {
    scene_.features = {.sides = sides, .fuzz = false, .capsules = false};
    scene_.bvh = tables_.view();
    for (std::uint32_t slot = 0; slot < tables_.slot_count(); ++slot) {
      if (tables_.input_index(slot) != no_shape) slot_of_.at(tables_.input_index(slot)) = slot;
    }
    // Fills scratch memory, because no result may depend on its content.
    std::memset(&space_->paths, 0xA5, sizeof space_->paths);
    std::memset(&space_->queries, 0xA5, sizeof space_->queries);
    std::memset(space_->stack_t, 0xA5, sizeof space_->stack_t);
    std::memset(space_->stack_child, 0xA5, sizeof space_->stack_child);
  }

  std::vector<Hit<Real>> find(std::span<const Query<Real>> queries, std::uint32_t beam) override {
    space_->inside.clear();
    space_->beam = beam;
    space_->paths.count = static_cast<std::uint32_t>(queries.size());
    for (std::uint32_t i = 0; i < queries.size(); ++i) set_path(i, queries[i]);
    function_(scene_, *space_);
    std::vector<Hit<Real>> hits;
    for (std::uint32_t i = 0; i < queries.size(); ++i) {
      const std::uint32_t slot = space_->queries.slot[i];
      hits.push_back({space_->queries.t[i], slot == no_shape ? no_shape : tables_.input_index(slot),
                      space_->queries.leaving[i] != 0});
    }
    return hits;
  }

  [[nodiscard]] std::uint32_t depth() const override { return tables_.depth(); }

 private:
  void set_path(std::uint32_t i, const Query<Real>& query) {
    Paths<Real>& paths = space_->paths;
    paths.origin.set(i, query.ray.origin);
    paths.direction.set(i, query.ray.direction);
    paths.surface[i] = no_shape;
    for (std::uint32_t index = 0; index < slot_of_.size(); ++index) {
      if (query.sides.stands_on(index)) paths.surface[i] = slot_of_[index];
    }
    paths.normal.set(i, query.sides.normal());
    paths.inside[i] = InsideLists::none;
    for (const std::uint32_t index : query.sides.inside()) {
      paths.inside[i] = space_->inside.push(paths.inside[i], slot_of_.at(index));
    }
  }

  Find function_;
  WideBvh<Store, W> tables_;
  Scene scene_;
  std::unique_ptr<Space> space_;
  std::vector<std::uint32_t> slot_of_;  ///< slot of each sphere, by input index
};

/// Calls `function(std::integral_constant<int, W>, find)` with the kernels of an instruction set.
template <typename P, typename Function>
auto with_kernels_of(Isa isa, Function function) {
  using Real = typename P::Real;
  using Store = typename P::Store;
  constexpr bool single = sizeof(Store) == sizeof(float);
#define PARRAY_WITH(name)                                                                        \
  if (isa == Isa::name) {                                                                        \
    constexpr int w = single ? trace::name::float_width : trace::name::double_width;             \
    return function(std::integral_constant<int, w>{}, trace::name::kernels<Real, Store>().find); \
  }
  PARRAY_FOR_EACH_ISA(PARRAY_WITH)
#undef PARRAY_WITH
  throw std::logic_error("this build has no kernels for the instruction set");
}

/// The spheres of a scene as precision P stores them.
template <typename P>
using Stored = Spheres<typename P::Store>;

/// Makes a search for an instruction set that this machine supports. Without `tree` it is a linear
/// search. Without `sides` it is for paths that are inside no sphere.
template <typename P>
std::unique_ptr<LaneSearch<typename P::Real>> lane_search(Isa isa,
                                                          const Spheres<typename P::Store>& spheres,
                                                          bool tree, bool sides) {
  using Real = typename P::Real;
  using Store = typename P::Store;
  return with_kernels_of<P>(isa, [&](auto width, auto find) -> std::unique_ptr<LaneSearch<Real>> {
    using Search = LaneSearchOf<Real, Store, decltype(width)::value>;
    return std::make_unique<Search>(find, spheres, tree, sides);
  });
}

}  // namespace parray::test
