#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "common/scene/settings_fwd.h"
#include "common/schedule/cell_grid.h"
#include "proto/payloads.h"

namespace parray::coordinator {

/// The referee: traces cells again for the coordinator, to decide disputes. An interface, so that
/// tests can replace RefereeProcess, which starts a process. Calls never block. Not thread-safe.
class Referee {
 public:
  /// Cells to trace.
  struct Question {
    std::uint64_t id = 0;  ///< from 1; the answer has the same
    std::string scene;     ///< SHA-256 of the scene's bytes; equal: the scene is the same
    ScenePayload payload;  ///< the scene
    Boxed<RenderSettings> settings;
    CellBatch cells;
    /// Limit in bytes of the memory for scene and accelerator. RefereeProcess applies it only when
    /// a question starts the process: later questions to the same process do not change the limit.
    std::uint64_t memory = 0;
  };
  /// The traced cells, or the reason why there are none.
  struct Answer {
    std::uint64_t id = 0;  ///< id of the question; 0: see forget()
    std::string failure;   ///< why the cells were not traced; empty: they were
    CellsPayload cells;
    double seconds = 0;        ///< processor time of building and tracing
    std::uint64_t memory = 0;  ///< bytes that the referee uses now; 0: unknown, or it has ended
  };

  Referee& operator=(Referee&&) = delete;
  virtual ~Referee() = default;

  /// Asks a question. The previous question must be answered, or cancelled by forget().
  virtual void ask(Question question) = 0;
  /// Returns the answers that have arrived since the last call.
  virtual std::vector<Answer> take_answers() = 0;
  /// Cancels the current question, discards answers that were not taken, and frees the referee's
  /// memory. Later, an answer with the id 0 may report the processor time that the cancelled
  /// question took.
  virtual void forget() = 0;
};

}  // namespace parray::coordinator
