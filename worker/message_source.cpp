#include "worker/message_source.h"

#include <algorithm>
#include <utility>

namespace parray::worker {

/// Number of scenes kept in memory: the current job's and the next job's.
static constexpr std::size_t scenes_kept = 2;

static LeaseKey key_of(const msg::Grant& grant) { return {grant.job, grant.epoch}; }

void MessageSource::receive(Time now, const PeerId& from, const Envelope& content) {
  try {
    Message message = content.open();
    if (from.empty()) last_heard_ = now;
    if (!exchange_.receive(now, from, message) && from.empty()) {
      std::visit([&](auto& m) { on(now, m); }, message);
    }
  } catch (const ProtocolError&) {
    // Drops the message: the protocol repeats it.
  }
}

LeaseSource::Taken MessageSource::take(Time /*now*/, double /*samples_per_second*/, bool /*idle*/) {
  if (waiting_.empty()) return {};
  const auto scene = std::ranges::find_if(
      scenes_, [&](const KnownScene& known) { return known.id == waiting_.front().scene; });
  if (scene == scenes_.end()) {
    return {};  // tick() fetches it
  }
  std::rotate(scene, scene + 1, scenes_.end());
  msg::Grant grant = std::move(waiting_.front());
  waiting_.pop_front();
  tracing_ = key_of(grant);
  return {Answer::lease,
          {grant.job, grant.epoch, std::move(grant.cells), grant.settings, std::move(grant.scene),
           scenes_.back().scene, grant.longest}};
}

void MessageSource::complete(Time now, LeaseResult finished) {
  const LeaseKey lease = finished.key();
  if (tracing_ == lease) tracing_.reset();
  Message message = msg::Failed{finished.job, finished.epoch, finished.failure};
  if (finished.cells) {
    message = msg::Result{finished.job,
                          finished.epoch,
                          finished.cells->seconds,
                          finished.build_seconds,
                          finished.accelerator_bytes,
                          std::move(finished.isa),
                          CellsPayload(finished.cells),
                          finished.cells->range.count(),
                          std::move(finished.grid)};
  }
  keep_until_acknowledged(now, lease, std::move(message));
}

void MessageSource::keep_until_acknowledged(Time now, const LeaseKey& lease, Message message) {
  // The message is encoded once, even if it is sent several times. Within one process it is never
  // encoded.
  Envelope envelope = options_.in_process ? Envelope(std::move(message)) : encode(message);
  if (connected_) outbox_.push_back({{}, envelope});
  unacknowledged_[lease] = {std::move(envelope), now + silence_};
}

Time MessageSource::tick(Time now, const TeamState& team) {
  if (!refusal_.empty()) return never;
  if (connected_ && last_heard_ + silence_ <= now) reconnect(now);
  if (next_heartbeat_ <= now) send_heartbeat(now, team);
  const Time due = std::min(next_heartbeat_, fetch_scenes(now));
  return connected_ ? std::min(due, repeat_unacknowledged(now)) : due;
}

/// Fetches the scenes of waiting leases, one after the other. Returns the time when it is due
/// again.
Time MessageSource::fetch_scenes(Time now) {
  const auto next =
      std::ranges::find_if(waiting_, [&](const msg::Grant& grant) { return !knows(grant.scene); });
  exchange_.want(next == waiting_.end() ? std::string() : next->scene);
  Time due = exchange_.tick(now);
  while (auto opened = exchange_.take_opened()) {
    if (!opened->scene) {
      fail_waiting(now, opened->id, opened->failure);
    } else if (!knows(opened->id)) {
      scenes_.push_back({opened->id, std::move(opened->scene)});
      due = now;  // a lease waits for it
    }
  }
  while (scenes_.size() > scenes_kept) scenes_.pop_front();
  return due;
}

void MessageSource::fail_waiting(Time now, const std::string& scene, const std::string& reason) {
  for (const msg::Grant& grant : waiting_) {
    if (grant.scene == scene) {
      keep_until_acknowledged(now, key_of(grant), msg::Failed{grant.job, grant.epoch, reason});
    }
  }
  std::erase_if(waiting_, [&](const msg::Grant& grant) { return grant.scene == scene; });
}

bool MessageSource::knows(const std::string& scene) const {
  return std::ranges::any_of(scenes_, [&](const KnownScene& known) { return known.id == scene; });
}

/// Sends due results and failures again. Returns the time when the next one is due.
Time MessageSource::repeat_unacknowledged(Time now) {
  Time next = never;
  for (auto& [lease, waiting] : unacknowledged_) {
    if (waiting.resend_at <= now) {
      outbox_.push_back({{}, waiting.message});
      waiting.resend_at = now + silence_;
    }
    next = std::min(next, waiting.resend_at);
  }
  return next;
}

std::vector<Delivery> MessageSource::take_outbox() {
  for (Delivery& delivery : exchange_.take_outbox()) outbox_.push_back(std::move(delivery));
  return std::exchange(outbox_, {});
}

void MessageSource::leave(const std::string& reason) {
  waiting_.clear();
  tracing_.reset();
  unacknowledged_.clear();
  send(msg::Bye{reason});
  connected_ = false;
}

void MessageSource::reconnect(Time now) {
  connected_ = false;
  next_heartbeat_ = now;
}

void MessageSource::on_forgotten(Time now) {
  waiting_.clear();
  reconnect(now);
}

void MessageSource::on(Time now, msg::Welcome& m) {
  heartbeat_ = milliseconds(m.heartbeat_ms);
  silence_ = milliseconds(m.silence_ms);
  if (!connected_) {
    connected_ = true;
    next_heartbeat_ = now;
  }
}

void MessageSource::on(Time /*now*/, msg::Refuse& m) {
  if (!connected_) {  // a refusal repeated late cannot undo a welcome
    refusal_ = m.reason.empty() ? "no reason given" : m.reason;
  }
}

/// The message itself escapes and cuts the lines, and keeps only the last ones.
void MessageSource::on(Time /*now*/, msg::ShowLog& m) {
  send(msg::Log{m.request,
                options_.recent_log ? options_.recent_log() : std::vector<std::string>()});
}

void MessageSource::on(Time now, msg::Grant& m) {
  // Ignores leases beyond the worker's capacity: their deadlines will pass.
  if (connected_ && !holds(key_of(m)) && waiting_.size() < options_.capacity) {
    waiting_.push_back(std::move(m));
    next_heartbeat_ = now;  // report at once that the lease has arrived
  }
}

void MessageSource::on(Time /*now*/, msg::ResultVerdict& m) {
  unacknowledged_.erase({m.job, m.epoch});
}

void MessageSource::on(Time /*now*/, msg::Revoke& m) {
  const LeaseKey lease{m.job, m.epoch};
  unacknowledged_.erase(lease);
  std::erase_if(waiting_, [&](const msg::Grant& grant) { return key_of(grant) == lease; });
  if (tracing_ == lease) {
    tracing_.reset();  // the runner learns it from wants()
  }
}

bool MessageSource::holds(const LeaseKey& lease) const {
  return tracing_ == lease || unacknowledged_.contains(lease) ||
         std::ranges::any_of(waiting_,
                             [&](const msg::Grant& grant) { return key_of(grant) == lease; });
}

void MessageSource::send_heartbeat(Time now, const TeamState& team) {
  next_heartbeat_ = now + heartbeat_;
  if (!connected_) {
    send(msg::Hello(options_));
    return;
  }
  msg::Heartbeat heartbeat;
  heartbeat.traced = team.traced;
  heartbeat.load = options_.load ? options_.load() : -1;
  heartbeat.preparing = team.preparing || (!tracing_ && !waiting_.empty());
  if (tracing_) heartbeat.epochs.push_back(*tracing_);
  for (const msg::Grant& grant : waiting_) heartbeat.epochs.push_back(key_of(grant));
  send(std::move(heartbeat));
}

}  // namespace parray::worker
