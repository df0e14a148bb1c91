#include "coordinator/loop/worker_logs.h"

#include <spdlog/fmt/fmt.h>

#include <algorithm>
#include <utility>

namespace parray::coordinator {

void WorkerLogs::on(Time now, const PeerId& peer, msg::ShowLog& m) {
  const bool repeated = std::ranges::any_of(waiting_, [&](const auto& entry) {
    return entry.second.client == peer && entry.second.request == m.request;
  });
  if (repeated) return;
  const WorkerRecord* worker = farm_.workers.by_name(m.name);
  if (worker == nullptr) {
    farm_.fail_request(peer, m.request, 2, farm_.why_no_worker(m.name));
    return;
  }
  if (waiting_.size() >= most_waiting) {
    farm_.send(peer, msg::Error{m.request, 1,
                                fmt::format("{} requests for logs of workers wait: try again later",
                                            waiting_.size()),
                                true});
    return;
  }
  waiting_[next_] = {peer, m.request, worker->peer, m.name, now + patience};
  farm_.send(worker->peer, msg::ShowLog{next_, m.name});
  ++next_;
}

void WorkerLogs::on(Time /*now*/, const PeerId& peer, msg::Log& m) {
  const auto found = waiting_.find(m.request);
  if (found == waiting_.end() || found->second.worker != peer) {
    return;  // it came too late
  }
  farm_.send(found->second.client, msg::Log{found->second.request, std::move(m.lines)});
  waiting_.erase(found);
}

Time WorkerLogs::expire(Time now) {
  // The numbers grow with the time, so the oldest request is the first.
  while (!waiting_.empty() && waiting_.begin()->second.until <= now) {
    const Waiting& waiting = waiting_.begin()->second;
    farm_.fail_request(
        waiting.client, waiting.request, 1,
        fmt::format("worker '{}' did not send its log within {:.0f} s: it is stopped, busy or of "
                    "an older release; read its output on its machine",
                    waiting.name, to_seconds(patience)));
    waiting_.erase(waiting_.begin());
  }
  return waiting_.empty() ? never : waiting_.begin()->second.until;
}

}  // namespace parray::coordinator
