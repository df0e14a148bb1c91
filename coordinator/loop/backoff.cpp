#include "coordinator/loop/backoff.h"

#include <algorithm>

namespace parray::coordinator {

void Backoff::note_failure(Time now, const MachineId& machine, const std::string& name,
                           bool whole) {
  if (until(machine, name) > now) return;
  constexpr std::size_t most = 10000;  // a worker can invent names: old entries are removed
  if (entries_.size() >= most) {
    std::erase_if(entries_, [&](const auto& e) { return e.second.until + longest < now; });
  }
  Entry& entry = entries_[{machine, whole ? "" : name}];
  entry.length = entry.length == Time(0) ? first : std::min(2 * entry.length, longest);
  entry.until = now + entry.length;
}

bool Backoff::forgive(const MachineId& machine, const std::string& name) {
  return entries_.erase({machine, ""}) + entries_.erase({machine, name}) > 0;
}

Time Backoff::until(const MachineId& machine, const std::string& name) const {
  Time until{};
  if (entries_.empty()) return until;
  for (const std::string& of : {std::string(), name}) {
    const auto found = entries_.find({machine, of});
    until = found == entries_.end() ? until : std::max(until, found->second.until);
  }
  return until;
}

}  // namespace parray::coordinator
