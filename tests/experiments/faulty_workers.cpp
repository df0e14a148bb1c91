// How soon machines that lie are found, and what gets through, on a farm of many machines: the real
// policy of checks (coordinator/disputes/check_policy.h) in a model of leases without pictures. A
// lie is found when a check of it goes to an honest machine or to the referee. Faulty workers
// confirm each other's lies and never lie about an honest machine's lease, so that they give
// nothing away.
#include <algorithm>
#include <cstdint>
#include <cstdlib>
#include <iostream>
#include <memory>
#include <set>
#include <vector>

#include "coordinator/disputes/check_policy.h"
#include "tests/support/dice.h"
#include "tests/support/rooms.h"

namespace {

using namespace parray;
using test::Dice;

struct Case {
  double faulty_workers = 0;  ///< share of the machines
  double lies = 1;            ///< share of a faulty worker's leases
};

constexpr std::size_t machines = 1000;
constexpr std::uint64_t leases_each = 2000;
constexpr std::uint64_t found_within = 500;

struct Machine {
  bool faulty = false;
  bool quarantined = false;
  std::uint64_t leases = 0;
  std::uint64_t first_lie = 0;       ///< its lease, from 1; 0: none yet
  std::vector<std::uint64_t> lies;   ///< leases that stand wrong in the picture
  std::vector<std::size_t> vouched;  ///< machines whose lies it confirmed
};

/// What came of one farm.
struct Outcome {
  std::uint64_t faulty_workers = 0;  ///< that lied at all
  std::uint64_t found = 0;
  std::uint64_t found_in_time = 0;  ///< before their 500th lease
  std::uint64_t honest_quarantined = 0;
  std::uint64_t lies = 0;     ///< told
  std::uint64_t through = 0;  ///< wrong at the end
  std::uint64_t wrong_of_quarantined = 0;
  std::uint64_t leases = 0;
  std::uint64_t checks = 0;
};

class Farm {
 public:
  Farm(const Case& its, std::uint64_t seed)
      : case_(its),
        dice_(seed),
        policy_({.share = 0.01}, [this] { return dice_.unit(); }),
        farm_(machines) {
    const auto faulty_workers = static_cast<std::size_t>(its.faulty_workers * machines + 0.5);
    for (std::size_t i = 0; i < faulty_workers; ++i) farm_[i].faulty = true;
  }

  Outcome run() {
    for (std::uint64_t round = 0; round < leases_each; ++round) {
      for (std::size_t i = 0; i < machines; ++i) {
        if (!farm_[i].quarantined) trace(i);
      }
    }
    for (const Machine& machine : farm_) {
      outcome_.faulty_workers += machine.first_lie > 0 ? 1 : 0;
      outcome_.through += machine.lies.size();
      outcome_.wrong_of_quarantined += machine.quarantined ? machine.lies.size() : 0;
    }
    return outcome_;
  }

 private:
  /// One lease, and its check if there is one.
  void trace(std::size_t place) {
    Machine& machine = farm_[place];
    const CheckedWorker worker{machine.leases, machine.leases, false};
    ++machine.leases;
    ++outcome_.leases;
    const bool lie = machine.faulty && dice_.unit() < case_.lies;
    if (lie) {
      ++outcome_.lies;
      machine.lies.push_back(machine.leases);
      machine.first_lie = machine.first_lie == 0 ? machine.leases : machine.first_lie;
    }
    if (policy_.wants_check(worker)) check(place, lie);
  }

  /// Another machine, or the referee, traces a lease again.
  void check(std::size_t place, bool lie) {
    ++outcome_.checks;
    std::vector<std::size_t> others;
    for (std::size_t i = 0; i < machines; ++i) {
      if (i != place && !farm_[i].quarantined) others.push_back(i);
    }
    const auto drawn = policy_.draw_checker(others.size());
    if (!lie) {
      return;  // equal bits, whoever looks
    }
    if (!drawn || !farm_[others[*drawn]].faulty) {
      quarantine(place);
      return;
    }
    farm_[others[*drawn]].vouched.push_back(place);
  }

  /// What it traced is traced again; what it vouched for is checked again, by the referee, too.
  void quarantine(std::size_t place) {
    Machine& machine = farm_[place];
    if (machine.quarantined) return;
    machine.quarantined = true;
    machine.lies.clear();
    outcome_.honest_quarantined += machine.faulty ? 0 : 1;
    ++outcome_.found;
    outcome_.found_in_time += machine.leases < found_within ? 1 : 0;
    for (const std::size_t other : std::exchange(machine.vouched, {})) quarantine(other);
  }

  const Case case_;
  Dice dice_;
  CheckPolicy policy_;
  std::vector<Machine> farm_;
  Outcome outcome_;
};

}  // namespace

int main(int argc, char** argv) {
  const std::uint64_t farms = argc > 1 ? std::strtoull(argv[1], nullptr, 10) : 20;
  std::cout
      << "| faulty_workers | they lie in | found | before lease 500 | honest in quarantine | lies "
         "told | wrong at the end | of all leases | of machines in quarantine | checked |\n"
         "|---|---|---|---|---|---|---|---|---|---|\n";
  for (const double lies : {1.0, 0.01, 0.001}) {
    for (const double faulty_workers : {0.01, 0.05, 0.2}) {
      Outcome all;
      for (std::uint64_t seed = 1; seed <= farms; ++seed) {
        const Outcome one = Farm({faulty_workers, lies}, seed).run();
        all.faulty_workers += one.faulty_workers;
        all.found += one.found;
        all.found_in_time += one.found_in_time;
        all.honest_quarantined += one.honest_quarantined;
        all.lies += one.lies;
        all.through += one.through;
        all.wrong_of_quarantined += one.wrong_of_quarantined;
        all.leases += one.leases;
        all.checks += one.checks;
      }
      const auto share = [](std::uint64_t part, std::uint64_t whole) {
        return whole == 0 ? 0.0 : static_cast<double>(part) / static_cast<double>(whole);
      };
      std::cout << "| " << 100 * faulty_workers << " % | " << 100 * lies << " % | "
                << share(all.found, all.faulty_workers) << " | "
                << share(all.found_in_time, all.faulty_workers) << " | " << all.honest_quarantined
                << " | " << all.lies << " | " << all.through << " | "
                << share(all.through, all.leases) << " | " << all.wrong_of_quarantined << " | "
                << share(all.checks, all.leases) << " |" << std::endl;
    }
  }
  return EXIT_SUCCESS;
}
