#pragma once

#include <mpi.h>

#include <cstdint>
#include <functional>
#include <string>

#include "proto/clock.h"

namespace parray::mpi {

/// Initialises MPI (MPI_Init_thread) and finalises it at the end (MPI_Finalize). A process has one
/// object. Not thread-safe.
class MpiWorld {
 public:
  /// Sets the variable OMPI_MCA_osc as Debian's Open MPI needs it, unless the user has set it.
  /// Collective. Throws RunError if MPI does not start or does not support threads.
  MpiWorld();
  ~MpiWorld();
  MpiWorld& operator=(MpiWorld&&) = delete;

  [[nodiscard]] std::uint32_t rank() const { return rank_; }
  [[nodiscard]] std::uint32_t ranks() const { return ranks_; }
  /// Returns whether all ranks run on one machine.
  [[nodiscard]] bool one_machine() const { return one_machine_; }
  /// Returns the number of threads for this rank: its share of the available processors. By default
  /// mpirun binds a rank to a single core. MpiWorld removes that binding, but keeps a binding that
  /// the user requested.
  [[nodiscard]] std::uint32_t threads() const { return threads_; }
  /// Returns whether this is rank 0.
  [[nodiscard]] bool first() const { return rank_ == 0; }
  [[nodiscard]] MPI_Comm comm() const { return comm_; }

  /// Returns rank 0's text in every rank. Collective. Any length.
  std::string broadcast(std::string text) const;
  /// Returns the sum of the values of all ranks. Collective.
  [[nodiscard]] std::uint64_t sum(std::uint64_t value) const;
  /// Returns true in every rank if `value` is true in every rank. Collective.
  [[nodiscard]] bool all_of(bool value) const;

  /// Waits for all ranks without using a processor. Returns false if a rank is still missing after
  /// `patience`: then no other collective operation is possible. Calls `meanwhile` every
  /// millisecond. Collective.
  bool barrier(
      Time patience, const std::function<void()>& meanwhile = [] {}) const;

  /// Tells all other ranks that rank 0 has all results. Only rank 0 calls it, once. Does not wait.
  void announce_end() const;
  /// Returns whether rank 0 has called announce_end(). Only other ranks call it.
  bool end_announced();

 private:
  void inspect_machine();

  MPI_Comm comm_ = MPI_COMM_WORLD;
  MPI_Request end_ = MPI_REQUEST_NULL;  // receives the announcement; null in rank 0
  std::uint32_t rank_ = 0;
  std::uint32_t ranks_ = 1;
  bool one_machine_ = true;
  std::uint32_t threads_ = 1;
};

/// Returns the rank of this process from the environment that mpirun or srun --mpi=pmix sets, so
/// that it is known before MPI starts. 0 without either.
std::uint32_t rank_in_environment();

}  // namespace parray::mpi
