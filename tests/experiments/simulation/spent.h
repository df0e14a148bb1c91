#pragma once

#include "tests/support/rooms.h"

namespace parray::simulation {

/// Seconds of all cores of a rank, by what they did.
struct Spent {
  double start = 0;        ///< MPI, scene, accelerator
  double useful = 0;       ///< tracing a cell for the first time
  double inner = 0;        ///< threads that wait for the last one of a slice
  double leases = 0;       ///< taking leases, handing slices over, putting results
  double coordinator = 0;  ///< rank 0: taking results in
  double imbalance = 0;    ///< nothing left to do while others trace for the first time
  double tail = 0;         ///< tracing copies
  double ending = 0;       ///< everything is traced, but not in
  double faults = 0;       ///< stopped or dead; what a dead rank had not handed in

  [[nodiscard]] double sum() const {
    return start + useful + inner + leases + coordinator + imbalance + tail + ending + faults;
  }
  Spent& operator+=(const Spent& other) {
    start += other.start;
    useful += other.useful;
    inner += other.inner;
    leases += other.leases;
    coordinator += other.coordinator;
    imbalance += other.imbalance;
    tail += other.tail;
    ending += other.ending;
    faults += other.faults;
    return *this;
  }
};

/// In units of a core of speed 1.
inline Spent operator*(double speed, const Spent& s) {
  return {speed * s.start,  speed * s.useful,      speed * s.inner,
          speed * s.leases, speed * s.coordinator, speed * s.imbalance,
          speed * s.tail,   speed * s.ending,      speed * s.faults};
}

}  // namespace parray::simulation
