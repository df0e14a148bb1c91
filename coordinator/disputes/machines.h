#pragma once

#include <cstdint>
#include <map>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <string_view>
#include <vector>

#include "common/base/error.h"
#include "coordinator/loop/machine_id.h"
#include "proto/clock.h"
#include "proto/messages.h"

namespace parray::coordinator {

/// Remembers the machines that this process has seen, connected or not, up to a limit. Not
/// thread-safe.
class Machines {
 public:
  struct Known {
    std::string name;          ///< text_of() the machine, for people
    std::string worker;        ///< name of the worker that joined last
    std::string host;          ///< of that worker
    std::uint64_t leases = 0;  ///< number of leases accepted from it
    Time lost = Time::min();   ///< when a worker there last disappeared without `bye`; min: never
  };
  /// Notes that a worker has joined from a machine. Beyond the limit, forgets the machine with the
  /// smallest key. If that machine returns, it counts as new.
  void note(const MachineId& machine, const msg::Hello& hello) {
    Known& known = known_[machine_key(machine)];
    known.name = text_of(machine);
    known.worker = hello.name;
    known.host = hello.host;
    constexpr std::size_t most = 100000;
    if (known_.size() > most) known_.erase(known_.begin());
  }
  /// Notes that a worker of a machine was lost. It may return.
  void note_lost(std::uint64_t machine, Time now) { known_[machine].lost = now; }
  /// Returns when a machine that may check a lease last lost a worker; Time::min() if none has.
  /// `may_check` receives the key of a machine.
  [[nodiscard]] Time last_lost(const auto& may_check) const {
    Time last = Time::min();
    for (const auto& [machine, known] : known_) {
      if (known.lost > last && may_check(machine)) last = known.lost;
    }
    return last;
  }
  /// Counts an accepted lease of a machine. Returns the number of its earlier accepted leases.
  std::uint64_t count_lease(std::uint64_t machine) { return known_[machine].leases++; }
  /// Returns what is known of a machine. Empty texts: no worker has joined from it, or it was
  /// forgotten.
  [[nodiscard]] Known find(std::uint64_t machine) const {
    const auto found = known_.find(machine);
    return found == known_.end() ? Known{} : found->second;
  }

 private:
  std::map<std::uint64_t, Known> known_;
};

/// A machine that gets no leases because it returned wrong bits.
struct Quarantine {
  std::uint64_t machine = 0;  ///< machine_key()
  std::string name;           ///< text_of() the machine; empty: it has not joined since the restart
  std::string worker;         ///< name of its worker at that time; empty: unknown
  std::string host;           ///< of that worker; empty: unknown
  std::string reason;
  double since = 0;  ///< seconds since 1970
  double until = 0;  ///< seconds since 1970; 0: until it is readmitted
};

/// The machines in quarantine. A quarantine lasts until the machine is readmitted. Only the
/// quarantine of a machine known by its address (MachineId::Kind) ends after address_seconds,
/// because another machine may get the address.
///
/// Not thread-safe. Times are seconds since 1970 by the wall clock.
class QuarantineLedger {
 public:
  static constexpr double address_seconds = 24 * 3600;

  /// Puts a machine into quarantine from `since` on and sets `until`. False: it is there already.
  bool add(Quarantine quarantine);
  /// Finds a machine. Null: it is not in quarantine.
  [[nodiscard]] const Quarantine* find(std::uint64_t machine) const;
  /// Ends the quarantines of some machines, and returns their number. If `host`, `name` is the host
  /// of the machine's worker. Otherwise it is the name of a worker key, an address, text_of() the
  /// machine, or the name of its worker.
  std::size_t readmit(std::string_view name, bool host);
  /// Ends the quarantine of one machine. False: there was none.
  bool readmit(std::uint64_t machine) { return machines_.erase(machine) > 0; }
  /// Ends the quarantines whose time is over. Returns their number.
  std::size_t expire(double now);

  [[nodiscard]] const std::map<std::uint64_t, Quarantine>& all() const { return machines_; }

  [[nodiscard]] nlohmann::json to_json() const;
  /// Reads the output of to_json(). Throws nlohmann::json::exception.
  static QuarantineLedger from_json(const nlohmann::json& list);

 private:
  std::map<std::uint64_t, Quarantine> machines_;
};

/// The finding that a machine returned wrong bits: results that differ from correct tracing.
struct FaultFinding {
  /// Higher than that of every earlier finding, also after a restart of the coordinator.
  std::uint64_t number = 0;
  std::uint64_t machine = 0;  ///< machine_key() of the machine
  std::string worker;         ///< name of its worker at that time, for people
};

/// Keeps the latest finding of each machine. A finding remains after the quarantine: jobs that are
/// resumed later may contain results or checks of the machine. Not thread-safe.
class FaultFindings {
 public:
  /// Adds a finding with the next number. It replaces an earlier finding of the same machine. If
  /// there are more than `most`, removes the oldest.
  FaultFinding add(std::uint64_t machine, std::string worker);
  /// Returns the findings with numbers above `number`, in ascending order.
  [[nodiscard]] std::vector<FaultFinding> after(std::uint64_t number) const;
  /// Returns the number of the latest finding. 0: there is none.
  [[nodiscard]] std::uint64_t latest() const { return list_.empty() ? 0 : list_.back().number; }

  [[nodiscard]] nlohmann::json to_json() const;
  /// Reads the output of to_json(). Throws nlohmann::json::exception.
  static FaultFindings from_json(const nlohmann::json& list);

  static constexpr std::size_t most = 4096;

 private:
  std::vector<FaultFinding> list_;  ///< by number
};

/// Returns the error that the state's note "workers", which contains the findings, is not valid.
/// `why` says what is wrong with it.
RunError damaged_worker_note(std::string_view why);

}  // namespace parray::coordinator
