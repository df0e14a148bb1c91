#pragma once

#include <mpi.h>

#include <cstdint>
#include <functional>
#include <string>

#include "proto/clock.h"

namespace parray {

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
  /// Ranks on this machine, this one among them.
  [[nodiscard]] std::uint32_t ranks_here() const { return ranks_here_; }
  [[nodiscard]] bool one_machine() const { return ranks_here_ == ranks_; }
  [[nodiscard]] bool first() const { return rank_ == 0; }
  [[nodiscard]] MPI_Comm comm() const { return MPI_COMM_WORLD; }

  /// Rank 0's text, everywhere. Collective. Any length.
  std::string broadcast(std::string text) const;
  /// The sum of everybody's value. Collective.
  [[nodiscard]] std::uint64_t sum(std::uint64_t value) const;
  /// True everywhere if `value` is true everywhere. Collective.
  [[nodiscard]] bool all_of(bool value) const;

  /// Waits for all ranks, without burning a processor; false if that takes longer than `patience`.
  /// `meanwhile` is called every millisecond.
  [[nodiscard]] bool meet(
      Time patience, const std::function<void()>& meanwhile = [] {}) const;

 private:
  std::uint32_t rank_ = 0;
  std::uint32_t ranks_ = 1;
  std::uint32_t ranks_here_ = 1;
};

/// This process's rank as mpirun has put it into the environment, before MPI is started; 0 without
/// mpirun.
std::uint32_t rank_in_environment();

/// Threads for a rank that shares its machine's processors with `ranks_here` - 1 others. Undoes
/// mpirun's default of binding a rank to one core, but not what the user asked for with --bind-to.
std::uint32_t default_threads(std::uint32_t ranks_here);

}  // namespace parray
