#pragma once

#include <mpi.h>

#include <memory>
#include <vector>

#include "common/schedule/work_plan.h"
#include "proto/window.h"
#include "worker/lease_source.h"
#include "worker/window_leases.h"

/// Leases by messages, the classic master and workers: for MPI libraries whose windows do not work,
/// and to compare with. Requests and results go to rank 0, whose server answers when it is polled.
namespace parray {

/// A worker's end.
class MessageLeases final : public LeaseSource {
 public:
  explicit MessageLeases(MPI_Comm comm) : comm_(comm) {}

  Taken take(double samples_per_second, bool idle) override;
  void complete(const CellRange& range, std::span<const std::byte> records) override;
  void tell(WindowLayout::RankWord word, std::uint64_t value) override;

 private:
  MPI_Comm comm_;
};

/// Rank 0's end: does for every other rank, in rank 0's own memory, what the rank would do over a
/// window.
class MessageServer {
 public:
  /// `memory` is the window's; `leases[r]` are those of rank r, over it. All outlive the server.
  MessageServer(MPI_Comm comm, const WindowLayout& layout, std::span<std::byte> memory,
                std::vector<std::unique_ptr<WindowLeases>>& leases);

  /// Answers everything that has arrived.
  void poll();

 private:
  void answer_take(int rank);
  void receive_result(int rank);
  void receive_word(int rank);

  MPI_Comm comm_;
  const WindowLayout& layout_;
  std::span<std::byte> memory_;
  std::vector<std::unique_ptr<WindowLeases>>& leases_;
};

}  // namespace parray
