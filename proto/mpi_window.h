#pragma once

#include <mpi.h>

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "proto/window.h"

namespace parray::proto {

/// The memory of one rank in an MPI window: every operation is complete there on return
/// (MPI_Win_flush).
class MpiTarget final : public Window {
 public:
  /// `own`: the memory, if it is this rank's.
  MpiTarget(MPI_Win window, int rank, std::span<std::byte> own)
      : window_(window), rank_(rank), own_(own) {}

  std::uint64_t fetch_add(std::size_t word, std::uint64_t delta) override;
  std::uint64_t load(std::size_t word) override;
  void store(std::size_t word, std::uint64_t value) override;
  void put(std::size_t offset, std::span<const std::byte> bytes) override;

 private:
  std::uint64_t fetch_and(MPI_Op op, std::size_t word, std::uint64_t operand);

  MPI_Win window_;
  int rank_;
  std::span<std::byte> own_;
};

/// Memory of every rank over MPI: one MPI_Win_allocate, open to everybody for its whole life
/// (MPI_Win_lock_all).
///
/// Construction and destruction are collective. Throws RunError when MPI offers no such window. One
/// thread, the one that MPI was initialised in.
class MpiWindow {
 public:
  /// `bytes`: of this rank, at least a word; the first `zeroed` of them are 0 at first.
  MpiWindow(MPI_Comm comm, std::size_t bytes, std::size_t zeroed);
  ~MpiWindow();
  MpiWindow(const MpiWindow&) = delete;
  MpiWindow& operator=(const MpiWindow&) = delete;

  Window& of(std::uint32_t rank) { return targets_[rank]; }
  /// This rank's own.
  [[nodiscard]] std::span<std::byte> memory() const { return memory_; }

  /// Lets the operations of others on this rank's memory come in where MPI has no thread for that,
  /// and makes what has come in visible in memory().
  void progress();

  /// While nobody uses the window: the first `zeroed` bytes of this rank are 0 again.
  void clear(std::size_t zeroed);

  /// Collective. True if every operation, tried by every rank on words [0, ranks] of rank 0 and on
  /// another rank's first, gives what it should; the words are 0 again afterwards.
  bool works();

 private:
  MPI_Comm comm_;
  std::uint32_t rank_ = 0;
  std::uint32_t ranks_ = 1;
  MPI_Win window_ = MPI_WIN_NULL;
  std::span<std::byte> memory_;
  std::vector<MpiTarget> targets_;
};

/// Sends requests to rank 0 by two-sided messages: see RequestWindow.
RequestWindow::Ask ask_first_rank(MPI_Comm comm);
/// In rank 0: performs on `memory` every request that has arrived, and replies.
void answer_requests(MPI_Comm comm, std::span<std::byte> memory);

/// Throws RunError "doing WHAT: MPI's words" unless `code` is MPI_SUCCESS.
void check_mpi(int code, const char* what);

}  // namespace parray::proto
