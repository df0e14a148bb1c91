#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <span>

#include "common/schedule/cell_grid.h"

namespace parray::proto {

/// The window: memory of one rank, the owner, that every rank can access. Tests replace MPI by
/// other windows. PROTOCOL.md, "The window", describes layout and use.
///
/// A word has 64 bits and is addressed by its index. Operations on words are atomic. The owner of
/// the memory sees the data of a put() before it sees any later operation of the same rank. Not
/// thread-safe.
class Window {
 public:
  virtual ~Window() = default;
  /// Adds `delta` (modulo 2^64) and returns the previous value.
  virtual std::uint64_t fetch_add(std::size_t word, std::uint64_t delta) = 0;
  virtual std::uint64_t load(std::size_t word) = 0;
  virtual void store(std::size_t word, std::uint64_t value) = 0;
  /// Copies bytes to byte `offset`, which is a multiple of 8. Not atomic.
  virtual void put(std::size_t offset, std::span<const std::byte> bytes) = 0;
};

/// A window in the memory of this process: for a single rank, for the owner of a RequestWindow, and
/// for tests.
class LocalWindow final : public Window {
 public:
  /// `memory` must outlive the window and be aligned to 8 bytes. The constructor changes nothing.
  explicit LocalWindow(std::span<std::byte> memory) : memory_(memory) {}
  std::uint64_t fetch_add(std::size_t word, std::uint64_t delta) override;
  std::uint64_t load(std::size_t word) override;
  void store(std::size_t word, std::uint64_t value) override;
  void put(std::size_t offset, std::span<const std::byte> bytes) override;

 private:
  std::span<std::byte> memory_;
};

/// An operation on a window, as a message. The bytes of a put follow in another message.
struct WindowRequest {
  enum class Operation : std::uint64_t { fetch_add, load, store, put };
  Operation operation = Operation::load;
  std::uint64_t place = 0;  ///< where: index of a word; for put: offset in bytes
  std::uint64_t value = 0;  ///< operand; for put: number of bytes
};

/// A window whose owner performs every operation on request, for MPI libraries without one-sided
/// communication. Every operation is complete on return.
class RequestWindow final : public Window {
 public:
  /// Sends a request, and the bytes of a put, to the owner. Returns the owner's reply.
  using Ask =
      std::function<std::uint64_t(const WindowRequest& request, std::span<const std::byte> bytes)>;

  explicit RequestWindow(Ask ask) : ask_(std::move(ask)) {}
  std::uint64_t fetch_add(std::size_t word, std::uint64_t delta) override {
    return ask_({Operation::fetch_add, word, delta}, {});
  }
  std::uint64_t load(std::size_t word) override { return ask_({Operation::load, word, 0}, {}); }
  void store(std::size_t word, std::uint64_t value) override {
    ask_({Operation::store, word, value}, {});
  }
  void put(std::size_t offset, std::span<const std::byte> bytes) override {
    ask_({Operation::put, offset, bytes.size()}, bytes);
  }

 private:
  using Operation = WindowRequest::Operation;

  Ask ask_;
};

/// Performs a request on the owner's memory and returns the reply: the earlier value of a word, or
/// 0. `receive` fills the bytes of a put. Throws RunError if the request reaches outside `memory`.
std::uint64_t perform(const WindowRequest& request, std::span<std::byte> memory,
                      const std::function<void(std::span<std::byte> bytes)>& receive);

/// Divides ranks into groups. Each group has a ledger: the counters by which its ranks take
/// weighted leases from a part of a pass's cells. The ledger is in the memory of one rank, its
/// keeper. If there is only one ledger, rank 0 keeps it.
class Ledgers {
 public:
  /// Default number of ranks of a group: about as many as the memory of one rank can serve.
  static constexpr std::uint32_t group_ranks = 256;

  /// `ranks`: number of ranks of the mpirun. `each`: largest number of ranks of a group.
  explicit Ledgers(std::uint32_t ranks, std::uint32_t each = group_ranks);

  [[nodiscard]] std::uint32_t count() const { return count_; }
  /// Returns the keeper: rank 0 of a single ledger, otherwise the last rank of the group.
  [[nodiscard]] std::uint32_t keeper(std::uint32_t ledger) const;
  /// Returns the ledger of the group of `rank`.
  [[nodiscard]] std::uint32_t home(std::uint32_t rank) const;
  [[nodiscard]] bool is_keeper(std::uint32_t rank) const { return keeper(home(rank)) == rank; }
  /// Returns the part of the `total` missing cells of a pass that belongs to a ledger, as positions
  /// in the list of these cells (CellList).
  [[nodiscard]] CellRange part(std::uint32_t ledger, std::uint64_t total) const;

 private:
  std::uint32_t ranks_;
  std::uint32_t count_;
};

/// The layout of a window. Every keeper's memory also begins with the shared words; its `position`
/// and `speed` are the ledger.
class WindowLayout {
 public:
  /// Words that all ranks share. `step`, `position` and `log_head` may exceed what exists, because
  /// ranks add to them even when nothing is left to take.
  enum Word : std::size_t {
    step = 0,            ///< number of chunks taken (policies static, guided, factoring)
    position = 1,        ///< number of missing cells handed out (policy weighted)
    speed = 2,           ///< speed of the ledger's ranks, see SpeedSum
    copy_requests = 3,   ///< PROTOCOL.md: `tickets`; how often a rank has found no work left
    copies = 4,          ///< number of issued copies of unfinished cells
    log_head = 5,        ///< number of claimed log blocks, without each rank's first
    finished = 6,        ///< not 0: the pass has ended; see PROTOCOL.md
    root_heartbeat = 7,  ///< grows as long as rank 0 is alive
    shared_words = 8
  };
  /// Words that each rank has for itself.
  enum RankWord : std::size_t {
    beat = 0,        ///< heartbeat: number of samples traced, and beat_flags
    samples = 1,     ///< samples of completed leases
    busy = 2,        ///< nanoseconds spent tracing
    taking = 3,      ///< nanoseconds spent taking leases
    takes = 4,       ///< number of leases taken
    putting = 5,     ///< nanoseconds spent putting results
    build = 6,       ///< nanoseconds spent building the accelerator
    tree_bytes = 7,  ///< bytes of the accelerator
    stop = 8,        ///< not 0: rank 0 accepts no more results of this pass from this rank
    rank_words = 9
  };

  WindowLayout(const CellGrid& grid, std::uint32_t ranks);

  static std::size_t rank_word(std::uint32_t rank, RankWord word) {
    return shared_words + std::size_t{rank} * rank_words + word;
  }
  /// Returns the word that holds the cells of copy number `copy`, in the form of to_word().
  [[nodiscard]] std::size_t copy_word(std::uint64_t copy) const { return first_copy_ + copy; }
  /// Number of copies that a window can hold: many times the possible number of ranks.
  static constexpr std::uint64_t most_copies = 1U << 16;
  /// Returns the first of an entry's three words: range, entry_digest(), and rank plus 1. A rank
  /// fills the entries of a block in order; block r is the first of rank r.
  [[nodiscard]] std::size_t log_word(std::uint64_t entry) const {
    return first_log_ + entry_words * entry;
  }
  static constexpr std::size_t entry_words = 3;
  [[nodiscard]] std::uint64_t log_blocks() const { return log_blocks_; }
  static constexpr std::uint64_t block_entries = 16;
  /// Returns the offset of a cell's record in bytes.
  [[nodiscard]] std::size_t record_offset(std::uint64_t cell) const {
    return first_record_ + cell * record_bytes_;
  }
  [[nodiscard]] std::size_t record_bytes() const { return record_bytes_; }
  [[nodiscard]] std::size_t bytes() const { return bytes_; }
  /// Returns the size of the part before the records in bytes. Its initial content must be 0.
  [[nodiscard]] std::size_t zeroed_bytes() const { return first_record_; }
  [[nodiscard]] std::uint32_t ranks() const { return ranks_; }
  [[nodiscard]] std::uint64_t cells() const { return cells_; }

 private:
  std::uint32_t ranks_;
  std::uint64_t cells_;
  std::size_t record_bytes_;
  std::uint64_t log_blocks_;
  std::size_t first_copy_;    // words
  std::size_t first_log_;     // words
  std::size_t first_record_;  // bytes
  std::size_t bytes_;
};

/// Packs a range of up to most_cells_in_word cells with indices below 2^40. The word 0: no range.
std::uint64_t to_word(const CellRange& range);
CellRange range_from_word(std::uint64_t word);
inline constexpr std::uint64_t most_cells_in_word = (1U << 24) - 1;

/// Returns the digest in a log entry, which depends on the digest of the records and on the rank.
std::uint64_t entry_digest(std::uint64_t range_digest, std::uint32_t rank);

/// Flags in the word `beat`; its other bits count samples.
namespace beat_flags {
inline constexpr std::uint64_t tracing = 1ULL << 63;   ///< has a lease
inline constexpr std::uint64_t building = 1ULL << 62;  ///< builds its accelerator
}  // namespace beat_flags

/// The sum of the speeds of a ledger's ranks in one word. So one atomic operation updates a rank's
/// own speed and reads the sum.
struct SpeedSum {
  std::uint64_t threads = 0;      ///< threads with a measured speed; upper 24 bits
  std::uint64_t kilosamples = 0;  ///< thousands of samples per second; lower 40 bits
  [[nodiscard]] std::uint64_t word() const { return (threads << 40) + kilosamples; }
  static SpeedSum from_word(std::uint64_t word) { return {word >> 40, word & ((1ULL << 40) - 1)}; }
};

}  // namespace parray::proto
