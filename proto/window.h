#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <span>

#include "common/schedule/cell_grid.h"

namespace parray::proto {

/// Memory of a rank's that every rank reaches without its help: the seam between leases over a
/// window and MPI. Layout and use are PROTOCOL.md's, "The window".
///
/// Words are 64 bits, addressed by index; operations on words are atomic among themselves. What
/// put() has written is there for its owner before any later operation of the same rank is.
/// One thread.
class Window {
 public:
  virtual ~Window() = default;
  /// Adds (modulo 2^64) and returns what was there before.
  virtual std::uint64_t fetch_add(std::size_t word, std::uint64_t delta) = 0;
  virtual std::uint64_t load(std::size_t word) = 0;
  virtual void store(std::size_t word, std::uint64_t value) = 0;
  /// Copies bytes to byte `offset`, which is a multiple of 8; not atomic.
  virtual void put(std::size_t offset, std::span<const std::byte> bytes) = 0;
};

/// Window in the memory of this process: for one rank alone, for ranks that send messages instead,
/// and for tests. The coordinator's own view of any window, too.
class LocalWindow final : public Window {
 public:
  /// `memory` outlives the window, is aligned to 8 bytes, and zero at first.
  explicit LocalWindow(std::span<std::byte> memory) : memory_(memory) {}
  std::uint64_t fetch_add(std::size_t word, std::uint64_t delta) override;
  std::uint64_t load(std::size_t word) override;
  void store(std::size_t word, std::uint64_t value) override;
  void put(std::size_t offset, std::span<const std::byte> bytes) override;

 private:
  std::span<std::byte> memory_;
};

/// An operation on a window, as a message carries it. The bytes of a put travel beside it.
struct WindowRequest {
  enum class Operation : std::uint64_t { fetch_add, load, store, put };
  Operation operation = Operation::load;
  std::uint64_t place = 0;  ///< a word; for put a byte
  std::uint64_t value = 0;  ///< for fetch_add the delta, for put the number of bytes
};

/// Window whose owner performs every operation on request: for MPI libraries without one-sided
/// communication. Every operation is complete on return.
class RequestWindow final : public Window {
 public:
  /// Sends a request, and the bytes of a put, to the owner. Returns the owner's reply.
  using Ask =
      std::function<std::uint64_t(const WindowRequest& request, std::span<const std::byte> bytes)>;

  explicit RequestWindow(Ask ask) : ask_(std::move(ask)) {}
  std::uint64_t fetch_add(std::size_t word, std::uint64_t delta) override;
  std::uint64_t load(std::size_t word) override;
  void store(std::size_t word, std::uint64_t value) override;
  void put(std::size_t offset, std::span<const std::byte> bytes) override;

 private:
  Ask ask_;
};

/// Performs a request on the owner's memory and returns the reply: the earlier value of a word, or
/// 0. `receive` fills the bytes of a put. Throws RunError if the request reaches outside `memory`.
std::uint64_t perform(const WindowRequest& request, std::span<std::byte> memory,
                      const std::function<void(std::span<std::byte> bytes)>& receive);

/// Weighted leases are taken from one ledger or more: each the memory of one rank, its keeper,
/// which only gives it, and each with a part of a pass's cells for a group of ranks. A single one
/// is rank 0's, which otherwise has enough to do.
class Ledgers {
 public:
  /// One for every so many ranks: about what one memory can answer.
  static constexpr std::uint32_t group_ranks = 256;

  /// `each`: ranks of a group, about.
  explicit Ledgers(std::uint32_t ranks, std::uint32_t each = group_ranks);

  [[nodiscard]] std::uint32_t count() const { return count_; }
  /// Rank 0 if there is only one ledger, else the last rank of the group.
  [[nodiscard]] std::uint32_t keeper(std::uint32_t ledger) const;
  /// Of the group that `rank` belongs to.
  [[nodiscard]] std::uint32_t home(std::uint32_t rank) const;
  [[nodiscard]] bool is_keeper(std::uint32_t rank) const { return keeper(home(rank)) == rank; }
  /// Of places [0, total) those of a ledger.
  [[nodiscard]] CellRange part(std::uint32_t ledger, std::uint64_t total) const;

 private:
  std::uint32_t ranks_;
  std::uint32_t count_;
};

/// Where everything lies in a window. The shared words are there in every keeper's memory, too, of
/// which `position` and `speed` are its ledger.
class WindowLayout {
 public:
  // Words that all ranks share.
  enum Word : std::size_t {
    step = 0,            ///< chunks taken: static, guided, factoring
    position = 1,        ///< cells handed out, of those that are missing: weighted
    speed = 2,           ///< of all ranks together: SpeedSum
    copy_requests = 3,   ///< ranks that have found nothing left, counted each time
    copies = 4,          ///< copies of unfinished cells that have been issued
    log_head = 5,        ///< blocks of the log that have been claimed, but for each rank's first
    finished = 6,        ///< not 0: every cell is in, or the job is given up
    root_heartbeat = 7,  ///< grows as long as rank 0 is alive
    shared_words = 8
  };
  /// Words of a rank's own.
  enum RankWord : std::size_t {
    beat = 0,        ///< samples traced, and Beat flags
    samples = 1,     ///< of completed leases
    busy = 2,        ///< nanoseconds spent tracing
    taking = 3,      ///< nanoseconds spent in taking leases
    takes = 4,       ///< leases taken
    putting = 5,     ///< nanoseconds spent in putting results
    build = 6,       ///< nanoseconds spent building the accelerator
    tree_bytes = 7,  ///< of the accelerator
    stop = 8,        ///< not 0: rank 0 wants no more of this pass from this rank
    rank_words = 9
  };

  WindowLayout(const CellGrid& grid, std::uint32_t ranks);

  static std::size_t rank_word(std::uint32_t rank, RankWord word) {
    return shared_words + std::size_t{rank} * rank_words + word;
  }
  [[nodiscard]] std::size_t copy_word(std::uint64_t copy) const { return first_copy_ + copy; }
  [[nodiscard]] std::uint64_t most_copies() const { return most_copies_; }
  /// An entry of the log is three words: the range, its entry_digest(), and the rank plus 1. A rank
  /// fills the entries of a block in their order; block r is the first of rank r.
  [[nodiscard]] std::size_t log_word(std::uint64_t entry) const {
    return first_log_ + entry_words * entry;
  }
  static constexpr std::size_t entry_words = 3;
  [[nodiscard]] std::uint64_t log_blocks() const { return log_blocks_; }
  static constexpr std::uint64_t block_entries = 16;
  /// Byte at which a cell's record lies.
  [[nodiscard]] std::size_t record_offset(std::uint64_t cell) const {
    return first_record_ + cell * record_bytes_;
  }
  [[nodiscard]] std::size_t record_bytes() const { return record_bytes_; }
  [[nodiscard]] std::size_t bytes() const { return bytes_; }
  /// Bytes at the beginning that have to be 0 at first: all but the records.
  [[nodiscard]] std::size_t zeroed_bytes() const { return first_record_; }
  [[nodiscard]] std::uint32_t ranks() const { return ranks_; }
  [[nodiscard]] std::uint64_t cells() const { return cells_; }

 private:
  std::uint32_t ranks_;
  std::uint64_t cells_;
  std::size_t record_bytes_;
  std::uint64_t most_copies_;
  std::uint64_t log_blocks_;
  std::size_t first_copy_;    // words
  std::size_t first_log_;     // words
  std::size_t first_record_;  // bytes
  std::size_t bytes_;
};

/// A range of cells in one word; 0 is none. Up to 2^40 cells, up to 2^24 - 1 of them in a range.
std::uint64_t to_word(const CellRange& range);
CellRange range_from_word(std::uint64_t word);
inline constexpr std::uint64_t most_cells_in_word = (1U << 24) - 1;

/// What an entry of the log has of a result: the digest of its records, and of who put them.
std::uint64_t entry_digest(std::uint64_t range_digest, std::uint32_t rank);

/// Flags in a rank's beat; the rest counts samples.
namespace beat_flags {
inline constexpr std::uint64_t tracing = 1ULL << 63;   ///< has a lease
inline constexpr std::uint64_t building = 1ULL << 62;  ///< makes its accelerator
}  // namespace beat_flags

/// Speeds of all ranks in one word, so that one atomic operation publishes a rank's own and reads
/// everybody's: threads whose speed is in (upper 24 bits), thousands of samples a second (lower
/// 40).
struct SpeedSum {
  std::uint64_t threads = 0;
  std::uint64_t kilosamples = 0;
  [[nodiscard]] std::uint64_t word() const { return (threads << 40) + kilosamples; }
  static SpeedSum from_word(std::uint64_t word) { return {word >> 40, word & ((1ULL << 40) - 1)}; }
};

}  // namespace parray::proto
