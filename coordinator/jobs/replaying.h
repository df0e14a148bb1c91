#pragma once

#include <string>

#include "coordinator/jobs/job_picture.h"
#include "coordinator/store/store.h"

namespace parray::coordinator {

struct TakenUp {
  bool complete = false;  ///< no pass is due: the picture is complete
  std::string damage{};  ///< why rows were left out, which are to be traced again; empty: none were
};

/// Merges the rows of earlier lives into the picture, and begins the pass that is due. At a damaged
/// row it stops and removes that row and all later ones from the store. `store` may be null. Throws
/// StorageFull, and what begin_pass() throws.
TakenUp take_up(JobPicture& picture, Store* store, JobId id);

}  // namespace parray::coordinator
