#pragma once

#include <atomic>

#include "common/trace/tracer.h"
#include "tests/support/rooms.h"
#include "tests/support/sim_network.h"
#include "tests/support/timed_cells.h"
#include "worker/cell_tracer.h"
#include "worker/team.h"

namespace parray::test {

/// A team that works in virtual time. It traces the samples at once, and returns them when a
/// machine with `samples_per_second` would have traced them. It returns a part of a lease that
/// takes too long.
class SimTeam final : public Team {
 public:
  SimTeam(const SimNetwork& network, double samples_per_second)
      : network_(network), speed_(samples_per_second) {}

  void start(LeaseWork assignment) override {
    const std::atomic<bool> stop = false;
    std::atomic<std::uint64_t> traced = 0;
    const auto tracer = make_path_tracer(*assignment.scene, assignment.settings);
    LeaseResult finished;
    finished.job = assignment.job;
    finished.epoch = assignment.epoch;
    const CellCost cost = [this](const CellBatch& batch, std::uint64_t cell) {
      return static_cast<double>(samples_of(batch, cell)) / speed_;
    };
    const TimedCells part = cells_within(assignment.cells, assignment.longest, cost);
    TracedCells cells = trace_cells(*tracer, part.cells, 1, traced, stop);
    cells.seconds = part.seconds;
    begun_ = network_.now();
    due_ = begun_ + from_seconds(cells.seconds);
    finished.cells = std::make_shared<const TracedCells>(std::move(cells));
    finished.grid = assignment.cells.grid;
    finished.isa = tracer->isa();
    finished_ = std::move(finished);
  }
  [[nodiscard]] bool idle() const override { return !finished_; }
  std::optional<LeaseResult> take() override {
    if (!finished_ || network_.now() < due_) return {};
    traced_ += finished_->cells->samples;
    return std::exchange(finished_, std::nullopt);
  }
  void abandon() override {
    traced_ = traced();
    finished_.reset();
  }
  [[nodiscard]] std::uint64_t traced() const override {
    if (!finished_) return traced_;
    const double part = to_seconds(std::min(network_.now(), due_) - begun_) * speed_;
    return traced_ + static_cast<std::uint64_t>(part);
  }
  [[nodiscard]] bool preparing() const override { return false; }
  /// Returns the time when the current lease is finished; `never` without a lease.
  [[nodiscard]] Time due() const { return finished_ ? due_ : never; }

 private:
  const SimNetwork& network_;
  double speed_;
  Time begun_{};
  Time due_{};
  std::uint64_t traced_ = 0;
  std::optional<LeaseResult> finished_;
};

}  // namespace parray::test
