#include "tests/support/sim_farm.h"

#include <spdlog/sinks/null_sink.h>


namespace parray::test {
namespace {

std::shared_ptr<spdlog::logger> silent_log() {
  return std::make_shared<spdlog::logger>("silent",
                                          std::make_shared<spdlog::sinks::null_sink_st>());
}

}  // namespace

SimFarm::SimFarm(Faults faults, std::uint64_t seed, CoordinatorOptions options)
    : network(faults, seed), options_(std::move(options)), store_(std::make_unique<MemoryStore>()) {
  options_.fingerprint = "same";
  restart_coordinator();
  client_link_ = network.peer_end("client");
}

void SimFarm::restart_coordinator() {
  coordinator_.reset();
  coordinator_ = std::make_unique<Coordinator>(options_, *store_, silent_log());
  coordinator_link_ = network.coordinator_end();
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
  Time next = std::min(take_turn(*coordinator_, *coordinator_link_, now), next_request_);
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
