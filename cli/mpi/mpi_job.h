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

/// What every rank needs to know of a job before it begins.
struct MpiJob {
  Boxed<RenderSettings> settings;
  MpiMode mode = MpiMode::window;
  std::uint32_t tile = 0;
  std::string fingerprint;  ///< of rank 0's tracing kernels
  std::string scene_bytes;  ///< empty in rank 0

  /// Whether rank 0 renders alone.
  [[nodiscard]] bool alone() const {
    return mode == MpiMode::openmp || mode == MpiMode::sequential;
  }
};

/// Rank 0 sends the job and the scene to all ranks; without a job (null) it tells them that there
/// is none. Collective.
std::optional<MpiJob> broadcast_job(const MpiWorld& world, const MpiJob* job,
                                    const std::string& scene_bytes = {});

/// Rank 0 sends a pass to all ranks; without one (null) it tells them that the job is finished.
/// Collective.
std::optional<RankPass> broadcast_pass(const MpiWorld& world, const MpiJob& job,
                                       const RankPass* pass);

/// A rank in the report.
struct RankFacts {
  std::string host;
  std::uint32_t threads = 1;
};

/// The ranks that take part.
struct Ranks {
  std::uint32_t count = 1;
  WindowOptions own;             ///< how this rank determines the size of its leases
  std::vector<RankFacts> facts;  ///< of all ranks in rank 0; default values in other ranks
};

/// Returns the ranks. Collective, unless rank 0 is alone. `threads`: of this rank.
Ranks find_ranks(const MpiWorld& world, const MpiJob& job, std::uint32_t threads);

}  // namespace parray::mpi
