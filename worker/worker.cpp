#include "worker/worker.h"

#include <algorithm>
#include <utility>

#include "common/base/bytes.h"
#include "common/scene/scene_bytes.h"

namespace parray {
namespace {

/// Scenes kept at hand: the current job's and the next one's.
constexpr std::size_t scenes_kept = 2;

}  // namespace

Worker::Worker(WorkerOptions options, Team& team) : options_(std::move(options)), team_(team) {}

void Worker::receive(Time now, Delivery delivery) {
  try {
    Message message = decode(delivery.frames);
    last_heard_ = now;
    std::visit([&](auto& m) { on(now, m); }, message);
  } catch (const ProtocolError&) {
    // Dropped: whatever it was, the protocol repeats it.
  }
}

Time Worker::tick(Time now) {
  if (!refusal_.empty()) {
    return never;
  }
  if (connected_ && last_heard_ + silence_ <= now) {
    disconnect(now);
  }
  collect(now);
  start_next(now);
  if (next_beat_ <= now) {
    beat(now);
  }
  Time next = next_beat_;
  if (connected_) {
    next = std::min(next, send_results_again(now));
  }
  return next;
}

/// Repeats results that have waited long enough for their verdict. Returns when the next is due.
Time Worker::send_results_again(Time now) {
  Time next = never;
  for (auto& [key, result] : results_) {
    if (result.resend_at <= now) {
      outbox_.push_back({{}, result.frames});
      result.resend_at = now + silence_;
    }
    next = std::min(next, result.resend_at);
  }
  return next;
}

std::vector<Delivery> Worker::take_outbox() { return std::exchange(outbox_, {}); }

void Worker::leave(const std::string& reason) {
  team_.abandon();
  waiting_.clear();
  tracing_.reset();
  results_.clear();
  send(msg::Bye{reason});
  connected_ = false;
}

void Worker::send(const Message& message) { outbox_.push_back({{}, encode(message)}); }

/// The coordinator is gone, or has forgotten this worker. Leases are dropped, because it will grant
/// their samples again; results are kept, because it may still want them.
void Worker::disconnect(Time now) {
  connected_ = false;
  waiting_.clear();
  next_beat_ = now;
}

void Worker::on(Time now, msg::Welcome& m) {
  heartbeat_ = milliseconds(m.heartbeat_ms);
  silence_ = milliseconds(m.silence_ms);
  if (!connected_) {
    connected_ = true;
    next_beat_ = now;
  }
}

void Worker::on(Time /*now*/, msg::Refuse& m) {
  if (!connected_) {  // a refusal repeated late cannot undo a welcome
    refusal_ = m.reason.empty() ? "no reason given" : m.reason;
  }
}

void Worker::on(Time /*now*/, msg::Pulse& /*m*/) {}

void Worker::on(Time now, msg::Who& /*m*/) { disconnect(now); }

void Worker::on(Time now, msg::Grant& m) {
  const LeaseKey key{m.job, m.epoch};
  if (!connected_ || holds(key)) {
    return;
  }
  if (waiting_.size() >= options_.capacity) {
    return;  // more than was asked for: its deadline will pass
  }
  waiting_.push_back(std::move(m));
  next_beat_ = now;  // say at once that the lease has come
}

void Worker::on(Time /*now*/, msg::SceneData& m) {
  if (scenes_.contains(m.scene) || scene_identity(m.bytes) != m.scene) {
    return;
  }
  try {
    scenes_[m.scene] = std::make_shared<const Scene>(scene_from_bytes(m.bytes));
    scene_age_.push_back(m.scene);
  } catch (const DecodeError&) {
    return;  // never from our own coordinator: it has read the same bytes
  }
  while (scene_age_.size() > scenes_kept) {
    scenes_.erase(scene_age_.front());
    scene_age_.pop_front();
  }
}

void Worker::on(Time /*now*/, msg::VerdictOf& m) { results_.erase({m.job, m.epoch}); }

void Worker::on(Time /*now*/, msg::Revoke& m) { forget({m.job, m.epoch}); }

void Worker::on(Time now, msg::Bye& /*m*/) { disconnect(now); }

bool Worker::holds(const LeaseKey& key) const {
  return tracing_ == key || results_.contains(key) ||
         std::any_of(waiting_.begin(), waiting_.end(), [&](const msg::Grant& grant) {
           return LeaseKey{grant.job, grant.epoch} == key;
         });
}

void Worker::forget(const LeaseKey& key) {
  results_.erase(key);
  std::erase_if(waiting_, [&](const msg::Grant& grant) {
    return LeaseKey{grant.job, grant.epoch} == key;
  });
  if (tracing_ == key) {
    team_.abandon();
    tracing_.reset();
  }
}

/// Takes a finished lease from the team and sends its result.
void Worker::collect(Time now) {
  auto finished = team_.take();
  if (!finished || !tracing_) {
    return;
  }
  const LeaseKey key{finished->job, finished->epoch};
  tracing_.reset();
  Frames frames =
      encode(msg::Result{finished->job, finished->epoch, finished->seconds, finished->build_seconds,
                         finished->accelerator_bytes, finished->isa, std::move(finished->block)});
  if (connected_) {
    outbox_.push_back({{}, frames});
  }
  results_[key] = {std::move(frames), now + silence_};
}

void Worker::start_next(Time now) {
  if (tracing_ || waiting_.empty() || !team_.idle()) {
    return;
  }
  const auto scene = scenes_.find(waiting_.front().scene);
  if (scene == scenes_.end()) {
    ask_for_scene(now);
    return;
  }
  msg::Grant grant = std::move(waiting_.front());
  waiting_.pop_front();
  std::erase(scene_age_, grant.scene);
  scene_age_.push_back(grant.scene);
  tracing_ = LeaseKey{grant.job, grant.epoch};
  team_.start({grant.job, grant.epoch, grant.rect, grant.settings, std::move(grant.samples),
               grant.scene, scene->second});
}

void Worker::ask_for_scene(Time now) {
  if (next_scene_request_ <= now) {
    send(msg::NeedScene{waiting_.front().scene});
    next_scene_request_ = now + heartbeat_;
  }
}

void Worker::beat(Time now) {
  next_beat_ = now + heartbeat_;
  if (!connected_) {
    send(msg::Hello{protocol_version, options_.name, options_.instance, options_.threads,
                    options_.capacity, trace_version, options_.fingerprint});
    return;
  }
  msg::Heartbeat heartbeat;
  heartbeat.traced = team_.traced();
  heartbeat.preparing = team_.preparing() || (!tracing_ && !waiting_.empty());
  if (tracing_) {
    heartbeat.epochs.push_back(*tracing_);
  }
  for (const msg::Grant& grant : waiting_) {
    heartbeat.epochs.emplace_back(grant.job, grant.epoch);
  }
  send(heartbeat);
}

}  // namespace parray
