#pragma once

#include <string>

#include "coordinator/jobs/job_picture.h"
#include "coordinator/store/store.h"

namespace parray::coordinator {

/// The state of a picture after take_up().
struct TakenUp {
  bool complete = false;  ///< the picture is complete: no pass is due
  std::string damage{};   ///< why cells of the log must be traced again; empty: none must
};

/// Replays the job's log into the picture and begins the pass that is due. If an entry is damaged,
/// removes it and all later ones from the store. `store` may be null. Throws StorageFull, and what
/// begin_pass() throws.
TakenUp take_up(JobPicture& picture, Store* store, JobId id);

}  // namespace parray::coordinator
