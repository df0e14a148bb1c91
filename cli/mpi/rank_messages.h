#pragma once

#include <mpi.h>

#include <memory>
#include <vector>

#include "proto/window.h"
#include "worker/window_source.h"

/// Leases of ranks by messages, the classic master and workers: for MPI libraries whose windows do
/// not work, and to compare with. Requests and results go to rank 0, whose server answers when it
/// is polled.
namespace parray::mpi {

/// A rank's end.
class RankMessages final : public RankSource {
 public:
  /// `job` and `pass` outlive the object.
  RankMessages(RankJob& job, const RankPass& pass, MPI_Comm comm)
      : RankSource(job, pass), comm_(comm) {}

  Part take_part(double samples_per_second, bool idle) override;
  void put(const CellRange& cells, std::span<const std::byte> records) override;
  void publish(WindowLayout::RankWord word, std::uint64_t value) override;

 private:
  MPI_Comm comm_;
};

/// Rank 0's end: does for every other rank, in rank 0's own memory, what the rank would do over a
/// window.
class MessageServer {
 public:
  /// `memory` is the window's; `sources[r]` is that of rank r, over it. All outlive the server.
  MessageServer(MPI_Comm comm, const WindowLayout& layout, std::span<std::byte> memory,
                std::vector<std::unique_ptr<WindowSource>>& sources)
      : comm_(comm), layout_(layout), memory_(memory), sources_(sources) {}

  /// Answers everything that has arrived.
  void poll();

 private:
  void answer_take(int rank);
  void receive_result(int rank);
  void receive_word(int rank);

  MPI_Comm comm_;
  const WindowLayout& layout_;
  std::span<std::byte> memory_;
  std::vector<std::unique_ptr<WindowSource>>& sources_;
};

}  // namespace parray::mpi
