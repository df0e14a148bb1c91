#pragma once

#include <algorithm>
#include <cstdint>
#include <string>
#include <vector>

#include "coordinator/jobs/journal.h"
#include "coordinator/leases/lease_table.h"
#include "coordinator/leases/result_collector.h"
#include "coordinator/loop/worker_registry.h"

namespace parray::coordinator {

/// A result of a lease after the job thread has decoded it, and merged it or compared it with
/// merged cells.
struct Merged {
  WorkerId worker = 0;
  TracerKey tracer = 0;              ///< key of the worker's process, for the journal
  TracerKey machine = 0;             ///< machine_key() of the worker's machine
  bool ours = false;                 ///< see Sender::ours
  std::uint64_t process_leases = 0;  ///< leases accepted from its process before this one
  std::string name;                  ///< of the worker
  Epoch epoch = 0;
  LeaseTable::Arrived arrived;
  enum class Kind : std::uint8_t {
    taken,    ///< the first result of its lease: merged; otherwise: compared, and equal
    differs,  ///< some merged cells have other bits
    damaged,  ///< its checksum is wrong: the cells must be traced again
    invalid,  ///< contains impossible numbers
    late,     ///< its pass had ended, or the picture had restarted, before the job thread saw it
  };
  Kind kind = Kind::late;
  std::string fault;             ///< what is wrong with a damaged or invalid result, for people
  ResultCollector::Taken taken;  ///< counts of its cells
  /// Digests of the result's cells, from ResultCollector::digests_of(). Empty unless it was
  /// compared.
  std::vector<std::uint64_t> digests;
  std::vector<ResultCollector::Differing> differing;  ///< the merged cells that differ from it
  bool whole = false;         ///< every pixel of the picture has a sample now
  std::uint64_t samples = 0;  ///< of all its cells, new or not
  std::uint32_t threads = 0;  ///< of the worker
  double charged = 0;         ///< thread-seconds that the job's user was charged for the lease
  double granted_at = 0;      ///< seconds since 1970
  double arrived_at = 0;      ///< seconds since 1970
  double seconds = 0;         ///< tracing time, stated by the worker
  double build_seconds = 0;   ///< time to build the accelerator, stated by the worker
  std::uint64_t accelerator_bytes = 0;
  std::string isa;  ///< instruction set that the worker used

  /// Returns the tracing time in seconds: as stated, but at most the time from the grant to the
  /// arrival.
  [[nodiscard]] double believable_seconds() const {
    return std::clamp(arrived_at - granted_at, 0.0, seconds);
  }
  /// Returns the entries for the job's journal: the merge, and before it the worker if `journal`
  /// does not have it yet. `digest`: see JournalMerge.
  [[nodiscard]] std::vector<JournalEntry> entries(const Journal& journal, std::uint32_t pass,
                                                  std::uint64_t digest) const {
    std::vector<JournalEntry> entries;
    if (!journal.knows(tracer)) entries.emplace_back(JournalWorker{tracer, threads, name});
    entries.emplace_back(JournalMerge{pass, tracer, epoch, arrived.range, samples, granted_at,
                                      arrived_at, seconds, digest});
    return entries;
  }
};

}  // namespace parray::coordinator
