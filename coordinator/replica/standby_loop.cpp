#include "coordinator/replica/standby_loop.h"

#include <algorithm>
#include <chrono>
#include <utility>

namespace parray::replica {
namespace {

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
  const std::string found = fmt::format("no primary has reached this standby for {:.0f} s",
                                        std::chrono::duration<double>(silent).count());
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

}  // namespace

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

Fence::Fence(std::unique_ptr<ZmqServer> server, std::uint64_t generation)
    : server_(std::move(server)), generation_(generation), thread_([this] { run(); }) {}

Fence::~Fence() {
  quit_ = true;
  thread_.join();
}

void Fence::run() {
  while (!quit_) {
    answer_all(server_->link(),
               [this](std::string_view message) { return fenced_answer(message, generation_); });
    server_->link().wait(wait_time);
  }
}

}  // namespace parray::replica
