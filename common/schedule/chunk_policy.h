#pragma once

#include <cstdint>
#include <vector>

#include "common/scene/settings.h"

namespace parray::schedule {

/// What a policy may look at. Work is counted in units, as a rule cells; a whole row is `row_units`
/// of them.
struct ChunkRequest {
  std::uint64_t total = 0;          ///< units of the whole job, > 0
  std::uint64_t remaining = 0;      ///< units not handed out yet, 1 .. total
  std::uint64_t step = 0;           ///< chunks handed out before this one
  std::uint64_t row_units = 1;      ///< units of one whole row, > 0
  std::uint32_t workers = 1;        ///< P > 0
  std::uint32_t threads = 1;        ///< threads of the asking worker, > 0
  double share = 1;                 ///< its measured speed over the sum of all, in (0, 1]
  std::uint64_t least = 1;          ///< units below which a lease costs more than it spreads, > 0
  std::uint64_t most = UINT64_MAX;  ///< units that one lease should not exceed, >= least
};

/// Units of the next chunk, 1 .. remaining. Pure: the same request has the same answer on every
/// side, so a simulator and an MPI rank compute what the coordinator would.
///
/// - static: total / P each, in whole rows.
/// - guided: ceil(R / P) rows, never below 2 rows a thread (the seed report, section 3.5;
///   Polychronopoulos and Kuck, 1987).
/// - factoring: batches of P equal chunks, each batch half of what is left, in whole rows
///   (Hummel, Schonberg, Flynn, 1992).
/// - weighted: half of the asking worker's share of what is left, by measured speed, parts of rows
///   included, between `least` and `most` (Hummel et al., 1996, weighted factoring).
std::uint64_t chunk_units(SchedulePolicy policy, const ChunkRequest& request);

/// Where every chunk of a job begins, and the total at the end, when all askers are alike: chunk
/// `step` is [result[step], result[step + 1]). What lets a worker compute its chunk from nothing
/// but a step number. Not for `weighted`, whose chunks depend on who asks.
std::vector<std::uint64_t> chunk_starts(SchedulePolicy policy, ChunkRequest job);

}  // namespace parray::schedule
