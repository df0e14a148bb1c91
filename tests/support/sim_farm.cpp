#include "tests/support/sim_farm.h"

#include <spdlog/sinks/null_sink.h>

#include <algorithm>
#include <set>

#include "common/base/bytes.h"
#include "common/scene/settings.h"
#include "tests/support/rooms.h"

namespace parray::test {
namespace {

std::shared_ptr<spdlog::logger> silent_log() {
  return std::make_shared<spdlog::logger>("silent",
                                          std::make_shared<spdlog::sinks::null_sink_st>());
}

}  // namespace

SimFarm::SimFarm(Faults faults, std::uint64_t seed, double failing_commits,
                 CoordinatorOptions options)
    : network(faults, seed),
      options_([&options] {
        options.fingerprint = "same";
        options.job_thread.threaded = false;
        return options;
      }()),
      store_(failing_commits, seed) {
  network.spy = [this](const Frames& frames) { note(decode(frames)); };
  start_coordinator();
  client_link_ = network.peer_end("client");
}

void SimFarm::note(const Message& message) {
  if (const auto* grant = std::get_if<msg::Grant>(&message)) {
    granted_[{grant->job, grant->epoch}] = {grant->pass, grant->cells.range.begin,
                                            grant->cells.range.end};
  }
  if (const auto* result = std::get_if<msg::Result>(&message)) {
    const std::pair lease(result->job, result->epoch);
    Cells cells = granted_.at(lease);
    if (result->count > 0) std::get<2>(cells) = std::get<1>(cells) + result->count;
    returned_[lease].insert(cells);
  }
  const auto* verdict = std::get_if<msg::ResultVerdict>(&message);
  if (verdict != nullptr && verdict->verdict == msg::Verdict::accepted) {
    acknowledged_.emplace(verdict->job, verdict->epoch);
  }
}

void SimFarm::start_coordinator() {
  CoordinatorOptions options = options_;
  options.first_epoch += Epoch{crashes_} << 32;
  coordinator_ = std::make_unique<Coordinator>(options, &store_, silent_log());
  coordinator_link_ = network.coordinator_end();
}

void SimFarm::crash_coordinator() {
  ++crashes_;
  coordinator_.reset();
  store_.crash();
  start_coordinator();
}

std::size_t SimFarm::acknowledged_but_lost() const {
  std::map<JobId, std::set<Cells>> kept;
  for (const auto& [job, epoch] : acknowledged_) {
    if (!kept.contains(job)) {
      for (const std::string& entry : store_.committed_rows(job)) {
        ByteReader in(entry);
        if (in.get<std::uint32_t>() != 1) {
          continue;  // not an entry of cells
        }
        const auto pass = in.get<std::uint32_t>();
        in.get<TracerKey>();
        const auto begin = in.get<std::uint64_t>();
        kept[job].emplace(pass, begin, in.get<std::uint64_t>());
      }
    }
  }
  return static_cast<std::size_t>(
      std::count_if(acknowledged_.begin(), acknowledged_.end(), [&](const auto& lease) {
        return !store_.has_picture(lease.first) &&
               std::ranges::none_of(returned_.at(lease), [&](const Cells& cells) {
                 return kept[lease.first].contains(cells);
               });
      }));
}

std::size_t SimFarm::parts() const {
  return static_cast<std::size_t>(std::ranges::count_if(returned_, [&](const auto& returned) {
    return std::ranges::any_of(
        returned.second, [&](const Cells& cells) { return cells != granted_.at(returned.first); });
  }));
}

Audit SimFarm::audit() {
  const std::string file = store_.picture(*job_).value_or("");
  const std::uint64_t size =
      picture_size(picture_->width, picture_->height, PictureDetail::statistics);
  return audit_journal(read_journal(std::string_view(file).substr(size)));
}

std::size_t SimFarm::add_worker(double samples_per_second, Ailments ailments) {
  const std::string id = "w" + std::to_string(next_peer_++);
  workers_.push_back(
      std::make_unique<SimWorker>(network, id, samples_per_second, ailments, next_peer_));
  return workers_.size() - 1;
}

void SimFarm::submit(const Scene& scene, const RenderSettings& settings) {
  msg::Submit submit;
  submit.request = 1;
  submit.token = "token";
  submit.name = "scene";
  submit.settings = settings;
  submit.scene = ScenePayload(std::make_shared<const Scene>(scene));
  request_ = std::move(submit);
}

void SimFarm::turn() {
  const Time now = network.now();
  client_turn();
  Time next = std::min(next_request_, take_turn(*coordinator_, *coordinator_link_, now));
  for (const auto& worker : workers_) {
    if (!worker) continue;
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
      const Message message = delivery->content.open();
      if (const auto* submitted = std::get_if<msg::Submitted>(&message)) {
        job_ = submitted->job;
      } else if (const auto* image = std::get_if<msg::ImageData>(&message)) {
        picture_ = *image;
      }
    } catch (const ProtocolError&) {
      // truncated by the network: the client asks again
    }
  }
  if (request_ && next_request_ <= network.now()) {
    next_request_ = network.now() + milliseconds(500);
    client_link_->send({}, job_ ? Message(msg::Fetch{2, *job_}) : Message(*request_));
  }
}

}  // namespace parray::test
