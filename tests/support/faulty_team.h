#pragma once

#include <cstring>
#include <memory>
#include <utility>

#include "common/image/cell_records.h"
#include "coordinator/leases/result_collector.h"
#include "tests/support/dice.h"
#include "tests/support/rooms.h"
#include "tests/support/sim_team.h"

namespace parray::test {

constexpr TracerKey honest_tracer = 1;
constexpr TracerKey faulty_tracer = 66;

/// Changes the sums of a cell to wrong values that are possible for its samples.
inline void falsify(TracedCells& cells, std::size_t record_bytes, std::uint64_t cell = 0) {
  std::byte* const at = cells.records.data() + cell * record_bytes + sizeof(CellHeader);
  PixelSums pixel;
  std::memcpy(&pixel, at, sizeof pixel);
  const bool less = pixel.odd[0] > 0;
  pixel.odd[0] -= less ? 1 : 0;
  pixel.sum[0] += pixel.sum[0] > 0 ? ~std::uint64_t{0} : 1;
  std::memcpy(at, &pixel, sizeof pixel);
}

inline std::shared_ptr<const TracedCells> falsified(const TracedCells& honest,
                                                    const CellGrid& grid) {
  auto cells = std::make_shared<TracedCells>(honest);
  falsify(*cells, record_bytes(grid.shape().cell_pixels));
  return cells;
}

/// Faults of a worker, each with its probability per lease.
struct Ailments {
  double lies = 0;   ///< one cell of the result has wrong sums
  double fails = 0;  ///< the worker reports that it cannot trace the lease
};

/// A simulated team with faults.
class FaultyTeam final : public Team {
 public:
  FaultyTeam(const SimNetwork& network, double samples_per_second, Ailments ailments,
             std::uint64_t seed)
      : team_(network, samples_per_second), ailments_(ailments), dice_(seed) {}

  void start(LeaseWork assignment) override { team_.start(std::move(assignment)); }
  [[nodiscard]] bool idle() const override { return team_.idle(); }
  std::optional<LeaseResult> take() override {
    auto finished = team_.take();
    if (finished && dice_.unit() < ailments_.fails) {
      finished->cells = nullptr;
      finished->failure = "not enough memory";
    } else if (finished && dice_.unit() < ailments_.lies) {
      finished->cells = falsified(*finished->cells, *finished->grid);
    }
    return finished;
  }
  void abandon() override { team_.abandon(); }
  [[nodiscard]] std::uint64_t traced() const override { return team_.traced(); }
  [[nodiscard]] bool preparing() const override { return false; }
  [[nodiscard]] Time due() const { return team_.due(); }

 private:
  SimTeam team_;
  const Ailments ailments_;
  Dice dice_;
};

}  // namespace parray::test
