#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "tests/support/rooms.h"

/// What things cost in a simulated job. Seconds and bytes a second throughout.
namespace parray::simulation {

/// Operations on rank 0's window.
struct LinkCosts {
  std::string name;
  std::string origin;           ///< measured where, or assumed
  double atomic = 0;            ///< fetch_add, load, store: until the answer is there
  double atomic_service = 0;    ///< of that, what rank 0's side cannot do two of at a time
  double put = 0;               ///< a put of no bytes: until it is complete
  double bytes_per_second = 1;  ///< of rank 0's link, which all puts share
  double own_atomic = 0;        ///< rank 0 itself
  double own_bytes_per_second = 1;
  bool needs_target = false;  ///< nothing gets on while rank 0's thread does something else
};

/// The links by name; the first is the default. tests/bench/window-latency measures the like.
const std::vector<LinkCosts>& known_links();
/// Throws InputError that lists the known names.
const LinkCosts& link_from(std::string_view name);

/// A rank's processor, apart from tracing. Measured by tests/bench/window-latency.
struct HostCosts {
  double hand_over = 10e-6;  ///< from one slice of a lease to the next: threads wake, fork
  double digest_bytes_per_second = 10e9;  ///< before a put
  double collect_entry = 0.1e-6;          ///< rank 0: a result
  double collect_cell = 0.064e-6;         ///< rank 0: a cell, checked and merged by one thread
  double look = 5e-9;                     ///< rank 0: at a rank's block of the log, in vain
};

/// Before the first cell is traced.
struct StartCosts {
  double mpi = 0;               ///< mpirun and MPI_Init, of one rank
  double mpi_per_doubling = 0;  ///< of the number of ranks
  double build = 0;             ///< of the accelerator, on one thread
  double scene_bytes = 0;
};

}  // namespace parray::simulation
