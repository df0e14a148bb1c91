#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "cli/mpi/mpi_options.h"
#include "cli/mpi/mpi_world.h"
#include "common/scene/settings_fwd.h"
#include "worker/window_source.h"

namespace parray::mpi {

/// The facts about a job that every rank needs before it begins.
struct MpiJob {
  Boxed<RenderSettings> settings;
  MpiMode mode = MpiMode::window;
  std::uint32_t tile = 0;   ///< side of the tiles in pixels; 0: runs of a row
  std::string fingerprint;  ///< trace_fingerprint() of rank 0
  std::string scene_bytes;  ///< set by broadcast_job(); empty if rank 0 is alone

  /// Returns whether rank 0 renders alone.
  [[nodiscard]] bool alone() const {
    return mode == MpiMode::openmp || mode == MpiMode::sequential;
  }
};

/// Sends the job and, unless rank 0 is alone, the scene from rank 0 to all ranks. Returns the job
/// in each of them. `job` is null in the other ranks. Null in rank 0: there is no job, and all
/// ranks return nothing. Collective.
std::optional<MpiJob> broadcast_job(const MpiWorld& world, const MpiJob* job,
                                    const std::string& scene_bytes = {});

/// Sends a pass from rank 0 to the other ranks, which return it. Rank 0 returns nothing. `pass` is
/// null in the other ranks. Null in rank 0: the job is finished, and all ranks return nothing.
/// Collective.
std::optional<RankPass> broadcast_pass(const MpiWorld& world, const MpiJob& job,
                                       const RankPass* pass);

/// A rank in the report.
struct RankFacts {
  std::string host;
  std::uint32_t threads = 1;
};

/// The ranks that render: all, or rank 0 alone.
struct Ranks {
  std::uint32_t count = 1;
  WindowOptions own;             ///< how this rank determines the size of its leases
  std::vector<RankFacts> facts;  ///< of all ranks; meaningful in rank 0 only
};

/// Returns the ranks that render. Collective, unless rank 0 is alone. `threads`: of this rank.
Ranks find_ranks(const MpiWorld& world, const MpiJob& job, std::uint32_t threads);

}  // namespace parray::mpi
