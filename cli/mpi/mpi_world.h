#pragma once

#include <mpi.h>

#include <cstdint>
#include <functional>
#include <string>

#include "proto/clock.h"

namespace parray::mpi {

/// MPI, from MPI_Init_thread to MPI_Finalize. One a process; one thread.
class MpiWorld {
 public:
  /// Sets what Debian's Open MPI needs, unless the user has set it. Throws RunError.
  MpiWorld();
  ~MpiWorld();
  MpiWorld(const MpiWorld&) = delete;
  MpiWorld& operator=(const MpiWorld&) = delete;

  [[nodiscard]] std::uint32_t rank() const { return rank_; }
  [[nodiscard]] std::uint32_t ranks() const { return ranks_; }
  /// All ranks are on one machine.
  [[nodiscard]] bool one_machine() const { return one_machine_; }
  /// Threads for this rank: its share of the processors that it may use. Of mpirun's default, which
  /// binds a rank to a single core, nothing is left; what the user asked for with --bind-to stays.
  [[nodiscard]] std::uint32_t threads() const { return threads_; }
  [[nodiscard]] bool first() const { return rank_ == 0; }
  [[nodiscard]] MPI_Comm comm() const { return comm_; }

  /// Rank 0's text, everywhere. Collective. Any length.
  std::string broadcast(std::string text) const;
  /// The sum of everybody's value. Collective.
  [[nodiscard]] std::uint64_t sum(std::uint64_t value) const;
  /// True everywhere if `value` is true everywhere. Collective.
  [[nodiscard]] bool all_of(bool value) const;

  /// Waits for all ranks, without burning a processor; false if that takes longer than `patience`.
  /// `meanwhile` is called every millisecond.
  bool barrier(
      Time patience, const std::function<void()>& meanwhile = [] {}) const;

 private:
  void look_at_machine();

  MPI_Comm comm_ = MPI_COMM_WORLD;
  std::uint32_t rank_ = 0;
  std::uint32_t ranks_ = 1;
  bool one_machine_ = true;
  std::uint32_t threads_ = 1;
};

/// This process's rank as mpirun, or srun --mpi=pmix, has put it into the environment, before MPI
/// is started; 0 without either.
std::uint32_t rank_in_environment();

}  // namespace parray::mpi
