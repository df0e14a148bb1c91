#include "coordinator/replica/standby_loop.h"

#include <algorithm>
#include <utility>

namespace parray::replica {
namespace {

constexpr Time wait_time = milliseconds(50);

/// Answers all received messages with the text that `answer` returns. Returns whether it sent any.
template <typename Answering>
bool answer_all(Link& link, const Answering& answer) {
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

}  // namespace

void standby_loop(Replica& replica, Link& link, Time patience, spdlog::logger& log,
                  const std::function<void()>& stop) {
  const SteadyClock clock;
  Time silent{};
  Time last = clock.now();
  bool in_step = false;
  while (silent < patience) {
    const bool answered =
        answer_all(link, [&](std::string_view message) { return replica.answer(message); });
    if (replica.in_step() != std::exchange(in_step, replica.in_step())) {
      in_step ? log.info("in step with the primary: this standby can take over")
              : log.warn("no longer in step with the primary: this standby cannot take over");
    }
    const Time now = clock.now();
    silent =
        answered || !replica.in_step() ? Time(0) : silent + std::min(now - last, 2 * wait_time);
    last = now;
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
