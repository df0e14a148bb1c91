#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "cli/commands/options.h"
#include "proto/window.h"

namespace parray::mpi {

/// How the ranks share the work.
enum class MpiMode : std::uint8_t {
  window,        ///< every rank takes leases from rank 0's window by itself
  messages,      ///< the same, by requests to rank 0 instead of one-sided communication
  static_split,  ///< over the window; each of P ranks traces 1/P of the rows, fixed in advance
  openmp,        ///< rank 0 alone, with all its threads
  sequential     ///< rank 0 alone, with one thread
};
/// Returns the word of --mode: "window", "messages", "static", "openmp" or "sequential".
std::string_view name_of(MpiMode mode);

/// The command line of parray-mpi.
struct MpiOptions {
  std::string scene;
  RenderOptions render;
  OutputOptions output;
  std::optional<std::uint32_t> threads;  ///< of each rank; nothing: its share of the processors
  MpiMode mode = MpiMode::window;
  std::uint32_t tile = 0;  ///< side of the tiles in pixels; 0: runs of a row
  /// Most ranks that take their leases from the memory of one rank.
  std::uint32_t ledger_ranks = Ledgers::group_ranks;
  std::string state;            ///< directory of --state; empty: IMAGE.state
  std::uint32_t patience = 60;  ///< seconds without progress before the job fails
  double checkpoint = 10;       ///< seconds between saves to disk
  bool row_seconds = false;     ///< the report has the tracing time of each row
  ProgressOptions following;

  /// Declares all options. The object must not move while the command line is parsed.
  void add_to(Command& command);
};

}  // namespace parray::mpi
