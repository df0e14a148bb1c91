#include "tests/support/sim_network.h"

#include <algorithm>
#include <cstdlib>

#include "tests/support/rooms.h"

namespace parray::test {
namespace {

constexpr const char* coordinator_id = "coordinator";

}  // namespace

std::string machine_of(const PeerId& worker) {
  return "machine-" + std::to_string(std::strtoul(worker.c_str() + 1, nullptr, 10) / 2);
}

PeerId outside_name(const PeerId& worker) {
  return peer_at("tcp://" + machine_of(worker) + ':' + worker.substr(1), SimNetwork::share_key);
}

PeerId inside_name(const PeerId& worker) {
  const std::size_t colon = worker.rfind(':') + 1;
  return 'w' + worker.substr(colon, worker.find(' ') - colon);
}

class SimNetwork::End final : public Link {
 public:
  End(SimNetwork& network, PeerId id) : network_(network), id_(std::move(id)) {}

  bool send(const PeerId& to, Envelope content) override {
    const bool to_worker = id_ != coordinator_id && !to.empty();
    network_.post(id_, id_ == coordinator_id ? to : (to_worker ? inside_name(to) : coordinator_id),
                  content.frames());
    return true;
  }
  std::optional<Delivery> receive() override {
    auto delivery = network_.arrived(id_);
    if (delivery && id_ == coordinator_id) {
      delivery->sender.address = machine_of(delivery->peer);
    } else if (delivery) {
      delivery->peer = delivery->peer == coordinator_id ? PeerId() : outside_name(delivery->peer);
    }
    return delivery;
  }
  void wait(Time /*timeout*/) override {}
  void wake() noexcept override {}

 private:
  SimNetwork& network_;
  PeerId id_;
};

std::unique_ptr<Link> SimNetwork::coordinator_end() { return peer_end(coordinator_id); }

std::unique_ptr<Link> SimNetwork::peer_end(const PeerId& id) {
  std::erase_if(in_flight_, [&](const auto& flight) { return flight.second.to == id; });
  return std::make_unique<End>(*this, id);
}

void SimNetwork::post(const PeerId& from, const PeerId& to, Frames frames) {
  ++tally_.sent;
  if (spy) spy(frames);
  if (chance(faults_.drop)) {
    ++tally_.dropped;
    return;
  }
  if (chance(faults_.repeat)) {
    ++tally_.repeated;
    launch(from, to, frames);
  }
  if (chance(faults_.truncate)) {
    ++tally_.truncated;
    Frame& victim = frames[random_() % frames.size()];
    if (chance(0.2) && frames.size() > 1) {
      frames.pop_back();
    } else if (victim.size() > 0) {
      victim = Frame(victim.owner(), victim.view().substr(0, random_() % victim.size()));
    }
  }
  launch(from, to, std::move(frames));
}

void SimNetwork::launch(const PeerId& from, const PeerId& to, Frames frames) {
  const auto delay = static_cast<std::int64_t>(
      random_() % static_cast<std::uint64_t>(faults_.longest_delay.count() + 1));
  in_flight_.emplace(now_ + Time(1 + delay), Flight{from, to, next_number_++, std::move(frames)});
}

std::optional<Delivery> SimNetwork::arrived(const PeerId& at) {
  for (auto flight = in_flight_.begin(); flight != in_flight_.end() && flight->first <= now_;
       ++flight) {
    if (flight->second.to != at) continue;
    Flight& message = flight->second;
    std::uint64_t& last = last_number_[message.from];
    tally_.overtaken += message.number < last ? 1U : 0U;
    last = std::max(last, message.number);
    Delivery delivery{message.from, std::move(message.frames)};
    in_flight_.erase(flight);
    return delivery;
  }
  return {};
}

}  // namespace parray::test
