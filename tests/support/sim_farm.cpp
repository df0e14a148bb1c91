#include "tests/support/sim_farm.h"

#include <spdlog/sinks/null_sink.h>

#include <algorithm>

namespace parray::test {
namespace {

std::shared_ptr<spdlog::logger> silent_log() {
  return std::make_shared<spdlog::logger>("silent",
                                          std::make_shared<spdlog::sinks::null_sink_st>());
}

}  // namespace

SimFarm::SimFarm(Faults faults, std::uint64_t seed, double failing_commits)
    : network(faults, seed), store_(failing_commits, seed) {
  network.spy = [this](const Frames& frames) {
    const Message message = decode(frames);
    if (const auto* verdict = std::get_if<msg::VerdictOf>(&message)) {
      if (verdict->verdict == msg::Verdict::accepted) {
        acknowledged_.emplace(verdict->job, verdict->epoch);
      }
    }
  };
  start_coordinator();
  client_link_ = network.peer_end("client");
}

void SimFarm::start_coordinator() {
  CoordinatorOptions options;
  options.fingerprint = "same";
  for (;;) {
    try {
      coordinator_ = std::make_unique<Coordinator>(options, store_, silent_log());
      break;
    } catch (const RunError&) {
      store_.crash();  // its first commit failed: somebody makes room on the disk, and again
    }
  }
  coordinator_link_ = network.coordinator_end();
}

void SimFarm::crash_coordinator() {
  ++crashes_;
  coordinator_.reset();
  store_.crash();
  start_coordinator();
}

std::size_t SimFarm::acknowledged_but_lost() const {
  return static_cast<std::size_t>(
      std::count_if(acknowledged_.begin(), acknowledged_.end(), [&](const auto& lease) {
        return !store_.has_block(lease.first, lease.second) && !store_.has_picture(lease.first);
      }));
}

std::size_t SimFarm::add_worker(double samples_per_second) {
  const std::string id = "w" + std::to_string(next_peer_++);
  workers_.push_back(std::make_unique<SimWorker>(network, id, samples_per_second));
  return workers_.size() - 1;
}

void SimFarm::submit(const Scene& scene, const RenderSettings& settings) {
  msg::Submit submit;
  submit.request = 1;
  submit.token = "token";
  submit.name = "scene";
  submit.settings = settings;
  submit.scene_bytes = scene_to_bytes(scene);
  request_ = std::move(submit);
}

void SimFarm::turn() {
  const Time now = network.now();
  client_turn();
  Time next = next_request_;
  try {
    next = std::min(next, take_turn(*coordinator_, *coordinator_link_, now));
  } catch (const RunError&) {
    crash_coordinator();  // it could not keep what it has: it ends, as its main() does
  }
  for (const auto& worker : workers_) {
    if (!worker) {
      continue;
    }
    if (worker->stopped_until > now) {
      next = std::min(next, worker->stopped_until);
      continue;
    }
    next = std::min(next, take_turn(worker->worker, *worker->link, now));
    next = std::min(next, worker->team.due());
  }
  next = std::min(next, network.next_arrival());
  // At least a step, so that a message for a stopped worker cannot stop the clock.
  network.advance_to(std::max(next, now + std::chrono::microseconds(100)));
}

void SimFarm::client_turn() {
  while (const auto delivery = client_link_->receive()) {
    try {
      const Message message = decode(delivery->frames);
      if (const auto* submitted = std::get_if<msg::Submitted>(&message)) {
        job_ = submitted->job;
      } else if (const auto* image = std::get_if<msg::ImageData>(&message)) {
        picture_ = *image;
      }
    } catch (const ProtocolError&) {
      // cut short on its way: asked for again
    }
  }
  if (request_ && next_request_ <= network.now()) {
    next_request_ = network.now() + milliseconds(500);
    client_link_->send({}, encode(job_ ? Message(msg::Fetch{2, *job_}) : Message(*request_)));
  }
}

}  // namespace parray::test
