#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "common/scene/settings_fwd.h"
#include "common/schedule/cell_grid.h"
#include "proto/parcels.h"

namespace parray::coordinator {

/// Traces cells on behalf of the coordinator, whose word decides a dispute: the seam to a process
/// of its own (RefereeProcess). Never blocks. One thread calls it.
class Referee {
 public:
  struct Question {
    std::uint64_t id = 0;
    std::string scene;  ///< scene_identity()
    SceneParcel parcel;
    Boxed<RenderSettings> settings;
    CellBatch cells;
    std::uint64_t memory = 0;  ///< bytes that it may take
  };
  struct Answer {
    std::uint64_t id = 0;
    std::string failure;  ///< why there are no cells; empty: there are
    CellsParcel cells;
    double seconds = 0;        ///< of processor time
    std::uint64_t memory = 0;  ///< bytes that it holds now
  };

  Referee() = default;
  Referee(const Referee&) = delete;
  Referee& operator=(const Referee&) = delete;
  virtual ~Referee() = default;

  /// Asks. The question before has been answered, or given up by forget().
  virtual void ask(Question question) = 0;
  /// Returns the answers that have arrived since the last call.
  virtual std::vector<Answer> take_answers() = 0;
  /// Gives up the current question and frees the referee's memory. The processor time that the
  /// question took may arrive later, as an answer without a number.
  virtual void forget() = 0;
};

}  // namespace parray::coordinator
