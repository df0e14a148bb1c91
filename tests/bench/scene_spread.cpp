// How long a scene takes to all workers: the real coordinator's and workers' code for it, in
// virtual time, over full-duplex links of a given rate. Prints seconds.
#include <cstdio>
#include <memory>
#include <queue>
#include <string>
#include <vector>

#include "common/process/command_line.h"
#include "common/process/run_main.h"
#include "tests/support/dice.h"
#include "tests/support/rooms.h"
#include "tests/support/sample_scenes.h"
#include "tests/support/sim_spread.h"

namespace parray {
namespace {

struct Arguments {
  std::size_t workers = 1000;
  double megabytes = 360;
  double mbit = 1000;
  double latency = 0.0002;
  bool star = false;
};

/// The virtual network carries chunks of this size as if they were of usual_chunk_bytes, so that a
/// large scene costs little memory.
constexpr std::uint32_t chunk_bytes = 512;
constexpr double scale = static_cast<double>(usual_chunk_bytes) / chunk_bytes;

Scene scene_of(double megabytes) {
  Scene scene = test::small_scene();
  test::Dice dice(1);
  const double spheres = megabytes * 1e6 / scale / static_cast<double>(scene_bytes_of_sphere);
  while (static_cast<double>(scene.spheres.size()) < spheres) {
    Sphere sphere = scene.spheres.front();
    sphere.center = dice.in_cube(1);
    sphere.radius = dice.between(0.1, 1);
    scene.spheres.push_back(sphere);
  }
  return scene;
}

/// Place 0 is the coordinator's.
class RatedNetwork {
 public:
  RatedNetwork(std::size_t places, double mbit, double latency)
      : bytes_per_second_(mbit * 1e6 / 8), latency_(latency), up_(places), down_(places) {}

  struct Arrival {
    double at;
    std::uint64_t number;
    std::size_t to;
    PeerId from;
    Message message;
    bool operator<(const Arrival& other) const {
      return std::pair(at, number) > std::pair(other.at, other.number);
    }
  };

  /// A message streams through: it takes its way's time once, behind what is on either link.
  void send(double now, std::size_t from, std::size_t to, PeerId name, Message message) {
    const double bytes = std::holds_alternative<msg::Chunk>(message) ? usual_chunk_bytes : 200;
    const double takes = bytes / bytes_per_second_;
    up_[from] = std::max(now, up_[from]) + takes;
    down_[to] = std::max(up_[from], down_[to] + takes);
    arrivals_.push({down_[to] + latency_, next_++, to, std::move(name), std::move(message)});
  }
  [[nodiscard]] bool empty() const { return arrivals_.empty(); }
  Arrival next() {
    Arrival arrival = arrivals_.top();
    arrivals_.pop();
    return arrival;
  }

 private:
  const double bytes_per_second_;
  const double latency_;
  std::vector<double> up_;  ///< until when each link is busy
  std::vector<double> down_;
  std::priority_queue<Arrival> arrivals_;
  std::uint64_t next_ = 0;
};

Time virtual_time(double seconds_now) { return from_seconds(seconds_now); }

double spread(const Arguments& a) {
  test::SpreadCoordinator coordinator(scene_of(a.megabytes), chunk_bytes);
  std::vector<std::unique_ptr<test::SpreadWorker>> workers;
  RatedNetwork network(a.workers + 1, a.mbit, a.latency);
  const auto name_of_place = [](std::size_t place) { return 'w' + std::to_string(2 * place); };
  const auto place_of = [](const PeerId& name) { return std::stoul(name.substr(1)) / 2; };
  const auto post = [&](double now, std::size_t place, Actor& actor) {
    for (Delivery& d : actor.take_outbox()) {
      const std::size_t to = place == 0
                                 ? place_of(d.peer)
                                 : (d.peer.empty() ? 0 : place_of(test::inside_name(d.peer)));
      const PeerId from =
          place == 0 ? PeerId()
                     : (to == 0 ? name_of_place(place) : test::outside_name(name_of_place(place)));
      network.send(now, place, to, from, d.content.open());
    }
  };
  for (std::size_t place = 1; place <= a.workers; ++place) {
    coordinator.add_worker(name_of_place(place), 2 * place, !a.star);
    workers.push_back(std::make_unique<test::SpreadWorker>(coordinator.id, test::Honesty::honest));
    workers.back()->tick(Time(0), true);
    post(0, place, *workers.back());
  }
  double last = 0;
  std::size_t left = a.workers;
  while (left > 0 && !network.empty()) {
    RatedNetwork::Arrival arrival = network.next();
    Actor& actor = arrival.to == 0 ? static_cast<Actor&>(coordinator) : *workers[arrival.to - 1];
    const bool before = arrival.to > 0 && workers[arrival.to - 1]->opened.has_value();
    actor.receive(virtual_time(arrival.at), {arrival.from, Envelope(std::move(arrival.message))});
    if (arrival.to > 0) {
      actor.tick(virtual_time(arrival.at), true);
      if (!before && workers[arrival.to - 1]->opened) {
        last = arrival.at;
        --left;
      }
    }
    post(arrival.at, arrival.to, actor);
  }
  if (left > 0) throw RunError("the scene has not come to all workers");
  return last;
}

}  // namespace
}  // namespace parray

int main(int argc, char** argv) {
  using namespace parray;
  const Program program = {"bench_scene_spread", "How long a scene takes to all workers", ""};
  Arguments a;
  return run_main(program, argc, argv, [&](CommandLine& line) {
    line.number("--workers", a.workers, 1, 30000, "Each on a machine of its own").show_default();
    line.number("--megabytes", a.megabytes, 1.0, 4000.0, "That travel").show_default();
    line.number("--mbit", a.mbit, 1.0, 1e6, "Of each link, each way, a second").show_default();
    line.number("--latency", a.latency, 0.0, 1.0, "Seconds of a message's way").show_default();
    line.flag("--star", a.star, "From the coordinator alone");
    return [&] {
      std::printf("%.3f\n", spread(a));
      return 0;
    };
  });
}
