#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "cli/mpi/mpi_world.h"
#include "proto/mpi_window.h"
#include "worker/window_source.h"

namespace parray::mpi {

/// The memory of rank 0 with leases and results (WindowLayout), and this rank's access to it.
/// window(), ledgers(), memory() and progress() need an earlier begin_pass().
class Transport {
 public:
  /// `world` outlives the object. `alone`: only rank 0 takes part. `by_messages`: without one-sided
  /// communication. `ledger_ranks`: most ranks of a ledger, the counters in one rank's memory by
  /// which a group of ranks takes leases (see Ledgers).
  Transport(const MpiWorld& world, bool alone, bool by_messages, std::uint32_t ledger_ranks)
      : world_(world),
        alone_(alone || world.ranks() == 1),
        ledger_ranks_(ledger_ranks),
        by_messages_(!alone_ && by_messages) {}
  ~Transport() { static_cast<void>(mpi_window_.release()); }
  Transport& operator=(Transport&&) = delete;

  /// Provides zeroed memory for a pass, as WindowLayout needs it. Reuses the memory of the previous
  /// pass if it is large enough; no rank may still use it. Collective, unless rank 0 is alone. If
  /// MPI has no window or the window fails its trial, ranks send requests from then on.
  void begin_pass(const WindowLayout& layout);

  /// Returns "window", "messages" or "memory" (rank 0 alone).
  [[nodiscard]] const char* name() const;
  /// Returns why MPI has no window although one was requested. Empty otherwise.
  [[nodiscard]] const std::string& fallback_reason() const { return fallback_reason_; }
  /// Returns whether other ranks send requests to rank 0 instead of using a window.
  [[nodiscard]] bool by_messages() const { return by_messages_; }
  /// Returns this rank's access to rank 0's window.
  [[nodiscard]] Window& window();
  /// Returns this rank's access to the ledgers. Without an MPI window rank 0 has the only ledger.
  [[nodiscard]] LedgerWindows ledgers();
  /// Returns this rank's own memory: in rank 0 leases and results, in other ranks a ledger, or
  /// nothing without an MPI window.
  [[nodiscard]] std::span<std::byte> memory();
  /// Lets operations of other ranks on this rank's memory complete, or answers their requests. Call
  /// it often.
  void progress();
  /// Closes the window. Collective. After an error it is not called, because other ranks may not
  /// answer; the window then stays open until the process ends.
  void close() { mpi_window_.reset(); }

 private:
  void open_window(const WindowLayout& layout);
  void clear(std::size_t zeroed);

  const MpiWorld& world_;
  const bool alone_;
  const std::uint32_t ledger_ranks_;
  bool by_messages_;
  std::size_t bytes_ = 0;  ///< size of the memory in rank 0
  std::string fallback_reason_;
  std::unique_ptr<MpiWindow> mpi_window_;
  std::vector<std::uint64_t> local_memory_;  // words, for their alignment
  std::unique_ptr<Window> own_window_;       ///< without an MPI window
};

}  // namespace parray::mpi
