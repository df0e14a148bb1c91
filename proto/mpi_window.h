#pragma once

#include <mpi.h>

#include <cstddef>
#include <span>

#include "proto/window.h"

namespace parray {

/// Rank 0's window over MPI: one MPI_Win_allocate, open to everybody for its whole life
/// (MPI_Win_lock_all), every operation complete at rank 0 on return (MPI_Win_flush). Its first
/// `zeroed` bytes are 0 at first.
///
/// Construction and destruction are collective. Throws RunError when MPI offers no such window. One
/// thread, the one that MPI was initialised in.
class MpiWindow final : public Window {
 public:
  MpiWindow(MPI_Comm comm, std::size_t bytes, std::size_t zeroed);
  ~MpiWindow() override;
  MpiWindow(const MpiWindow&) = delete;
  MpiWindow& operator=(const MpiWindow&) = delete;

  std::uint64_t fetch_add(std::size_t word, std::uint64_t delta) override;
  std::uint64_t load(std::size_t word) override;
  void store(std::size_t word, std::uint64_t value) override;
  void put(std::size_t offset, std::span<const std::byte> bytes) override;

  /// Rank 0's own memory; empty elsewhere.
  [[nodiscard]] std::span<std::byte> memory() const { return memory_; }

  /// Rank 0: lets the operations of others come in where MPI has no thread for that, and makes what
  /// has come in visible in memory().
  void progress();

  /// Rank 0, while nobody uses the window: its first `zeroed` bytes are 0 again.
  void clear(std::size_t zeroed);

  /// Collective. True if every operation, tried by every rank on words [0, ranks], gives what it
  /// should; the words are 0 again afterwards.
  bool works();

 private:
  std::uint64_t fetch_and(MPI_Op op, std::size_t word, std::uint64_t operand);

  MPI_Comm comm_;
  int rank_ = 0;
  MPI_Win window_ = MPI_WIN_NULL;
  std::span<std::byte> memory_;
};

/// Throws RunError "doing WHAT: MPI's words" unless `code` is MPI_SUCCESS.
void check_mpi(int code, const char* what);

}  // namespace parray
