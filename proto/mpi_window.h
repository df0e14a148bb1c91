#pragma once

#include <mpi.h>

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "proto/window.h"

namespace parray::proto {

/// The memory of one rank in an MPI window. Every operation is complete on return (MPI_Win_flush)
/// and throws RunError if MPI fails.
class MpiTarget final : public Window {
 public:
  /// `own` is the memory if `rank` is this rank, otherwise empty.
  MpiTarget(MPI_Win window, int rank, std::span<std::byte> own)
      : window_(window), rank_(rank), own_(own) {}

  std::uint64_t fetch_add(std::size_t word, std::uint64_t delta) override {
    return fetch_and(MPI_SUM, word, delta);
  }
  std::uint64_t load(std::size_t word) override { return fetch_and(MPI_NO_OP, word, 0); }
  void store(std::size_t word, std::uint64_t value) override {
    fetch_and(MPI_REPLACE, word, value);
  }
  void put(std::size_t offset, std::span<const std::byte> bytes) override;

 private:
  std::uint64_t fetch_and(MPI_Op op, std::size_t word, std::uint64_t operand);

  MPI_Win window_;
  int rank_;
  std::span<std::byte> own_;
};

/// The memory of all ranks in one MPI window (MPI_Win_allocate), open to all ranks until it is
/// destroyed (MPI_Win_lock_all).
///
/// Construction and destruction are collective. The constructor throws RunError if MPI offers no
/// such window. Use a window only in the thread that initialised MPI.
class MpiWindow {
 public:
  /// `bytes` is the size of this rank's memory, at least a word. Zeroes the first `zeroed` bytes.
  MpiWindow(MPI_Comm comm, std::size_t bytes, std::size_t zeroed);
  ~MpiWindow();
  MpiWindow& operator=(MpiWindow&&) = delete;

  Window& of(std::uint32_t rank) { return targets_[rank]; }
  /// Returns the memory of this rank.
  [[nodiscard]] std::span<std::byte> memory() const { return memory_; }

  /// Performs the operations of other ranks on this rank's memory if MPI has no thread for that,
  /// and makes their effects visible in memory().
  void progress();

  /// Sets the first `zeroed` bytes of this rank to 0. No rank may use the window meanwhile.
  void clear(std::size_t zeroed);

  /// Tests every operation on words [0, ranks] of rank 0 and on word 0 of every other rank. These
  /// words must be 0 before, and are 0 afterwards. Returns whether all is correct. Collective.
  bool works();

 private:
  MPI_Comm comm_;
  std::uint32_t rank_ = 0;
  std::uint32_t ranks_ = 1;
  MPI_Win window_ = MPI_WIN_NULL;
  std::span<std::byte> memory_;
  std::vector<MpiTarget> targets_;
};

/// Returns a function that sends requests to rank 0 by two-sided messages: see RequestWindow.
RequestWindow::Ask ask_first_rank(MPI_Comm comm);
/// Performs every request that has arrived at rank 0 on `memory`, and replies. Only for rank 0.
void answer_requests(MPI_Comm comm, std::span<std::byte> memory);

/// Throws RunError with the text `what` and MPI's message unless `code` is MPI_SUCCESS.
void check_mpi(int code, const char* what);

}  // namespace parray::proto
