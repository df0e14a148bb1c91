#include "coordinator/replica/state_owner.h"

#include <algorithm>
#include <random>
#include <thread>
#include <utility>

#include "coordinator/replica/replica.h"
#include "coordinator/store/disk_store.h"
#include "proto/keys.h"

namespace parray::replica {
namespace {

constexpr std::size_t most_message_bytes = std::size_t{64} << 20;  // pieces are far smaller

/// Opens the store. `wait`: waits while another coordinator uses it.
std::unique_ptr<Store> open_store(const std::string& directory, bool wait, spdlog::logger& log,
                                  const std::function<void()>& stop) {
  constexpr Time nap = milliseconds(100);
  for (bool told = false;;) {
    try {
      auto store = std::make_unique<DiskStore>(directory);
      for (const std::string& line : store->reports()) log.warn("--state {}: {}", directory, line);
      return store;
    } catch (const StateInUse&) {
      if (!wait) throw;
      if (!std::exchange(told, true)) {
        log.info("another coordinator uses --state {}: waiting for its end", directory);
      }
    }
    std::this_thread::sleep_for(nap);
    stop();
  }
}

std::uint64_t random_number() {
  std::random_device device;
  return (std::uint64_t{device()} << 32) + device();
}

constexpr Time wait_time = milliseconds(50);
constexpr Time reminder_pause = seconds(3600);

/// Answers all received messages with the text that `answer` returns. Returns whether it sent any.
bool answer_all(Link& link, const auto& answer) {
  bool answered = false;
  while (const auto delivery = link.receive()) {
    const Frames frames = delivery->content.frames();
    std::string text = frames.size() == 1 ? answer(frames[0].view()) : std::string();
    if (!text.empty()) {
      answered = true;
      link.send(delivery->peer, Frames{Frame(std::move(text))});
    }
  }
  return answered;
}

/// Says what a person can do for a standby that no primary reaches.
void warn_of_silence(const Replica& replica, Time silent, spdlog::logger& log) {
  const std::string found =
      fmt::format("no primary has reached this standby for {:.0f} s", to_seconds(silent));
  if (replica.can_serve()) {
    log.warn(
        "{}, and it cannot take over before it is in step: start the primary with --replicate-to "
        "and this standby's address. If the primary is lost, start this coordinator without "
        "--standby: it then serves its copy of the state",
        found);
  } else {
    log.warn(
        "{}, and it has no complete copy of a state yet: start the primary with --replicate-to and "
        "this standby's address",
        found);
  }
}

/// Answers the primary. Returns when the primary has been silent for `patience` while the store was
/// in step with it: the caller may then take over. While the store is not in step, logs the
/// remedies after a silence of `patience`, then every hour. Time in which this process did not run
/// does not count. Calls `stop` at least every 50 ms; an exception of `stop` ends the wait. Throws
/// what Replica::answer() throws.
void standby_loop(Replica& replica, Link& link, Time patience, spdlog::logger& log,
                  const std::function<void()>& stop) {
  const SteadyClock clock;
  Time silent{};
  Time next_warning = patience;  // of silence while the store is not in step
  Time last = clock.now();
  bool in_step = false;
  while (!in_step || silent < patience) {
    const bool answered =
        answer_all(link, [&](std::string_view message) { return replica.answer(message); });
    if (replica.in_step() != std::exchange(in_step, replica.in_step())) {
      in_step ? log.info("in step with the primary: this standby can take over")
              : log.warn("no longer in step with the primary: this standby cannot take over");
      next_warning = patience;
    }
    const Time now = clock.now();
    silent = answered ? Time(0) : silent + std::min(now - last, 2 * wait_time);
    last = now;
    if (!in_step && silent >= next_warning) {
      warn_of_silence(replica, silent, log);
      next_warning = silent + reminder_pause;
    }
    stop();
    link.wait(wait_time);
  }
}

}  // namespace

StateOwner::StateOwner(const StateOptions& options, spdlog::logger& log,
                       const std::function<void()>& stop)
    : directory_(options.state) {
  if (options.state.empty()) return;
  disk_ = open_store(options.state, options.wait, log, stop);
  if (options.standby.empty()) check_fence(*disk_, options.serve_fenced, random_number() | 1);
  if (!options.standby.empty()) {
    take_over(options, log, stop);
  } else if (!options.replicate_to.empty()) {
    replicate(options);
  } else {
    serve_alone(*disk_);
  }
}

void StateOwner::remember_fence() {
  replicated_.reset();
  connection_.reset();
  disk_.reset();
  DiskStore store(directory_);  // without uncommitted changes
  note_fence(store);
}

Store* StateOwner::store() { return replicated_ ? replicated_.get() : disk_.get(); }

void StateOwner::take_over(const StateOptions& options, spdlog::logger& log,
                           const std::function<void()>& stop) {
  standby_.emplace(options.standby, most_message_bytes, options.keys, Admits::itself);
  Replica replica(*disk_, options.overwrite);
  if (!replica.has_taken_over()) {
    log.info("standing by for a primary at {}", standby_->endpoint());
    standby_loop(replica, standby_->link(), options.takeover_after, log, stop);
  }
  const bool earlier = replica.has_taken_over();
  const std::uint64_t generation = serve_alone(*disk_);
  log.warn(
      "{}: it serves now, as generation {} of the farm's state. To have a standby again, start {} "
      "with --standby, and this coordinator with --replicate-to",
      earlier ? "this coordinator is no standby, because its state has served without one"
              : "the primary is silent, and this standby has taken over",
      generation,
      earlier ? "another coordinator with an empty directory and" : "the former primary");
  fence_ = std::jthread([generation, &link = standby_->link()](const std::stop_token& end) {
    const auto fenced = [&](std::string_view message) {
      return fenced_answer(message, generation);
    };
    while (!end.stop_requested()) {
      answer_all(link, fenced);
      link.wait(wait_time);
    }
  });
}

void StateOwner::replicate(const StateOptions& options) {
  std::optional<MemberKey> key;
  if (!options.keys.empty()) {
    const KeyPair own = read_coordinator_key(options.keys);
    key = MemberKey{own.open, own};
  }
  connection_ = std::make_unique<ReplicaThread>(
      zmq_connect(options.replicate_to, most_message_bytes, Time(0), key), options.replicate_to);
  replicated_ = std::make_unique<ReplicatedStore>(*disk_, *connection_, random_number);
}

}  // namespace parray::replica
