#include "coordinator/replica/standby_loop.h"

#include <algorithm>
#include <utility>

namespace parray::replica {
namespace {

constexpr Time look_interval = milliseconds(50);

/// Answers what has arrived, as `answer` says; true: there was something.
template <typename Answering>
bool answer_all(Link& link, const Answering& answer) {
  bool heard = false;
  while (const auto delivery = link.receive()) {
    const Frames frames = delivery->content.frames();
    std::string text = frames.size() == 1 ? answer(frames[0].view()) : std::string();
    if (!text.empty()) {
      heard = true;
      link.send(delivery->peer, Frames{Frame(std::move(text))});
    }
  }
  return heard;
}

}  // namespace

void standby_loop(Replica& replica, Link& link, Time patience, spdlog::logger& log,
                  const std::function<void()>& stop) {
  const SteadyClock clock;
  Time silent{};
  Time last = clock.now();
  bool told = false;
  while (silent < patience) {
    const bool heard =
        answer_all(link, [&](std::string_view message) { return replica.answer(message); });
    if (replica.in_step() != std::exchange(told, replica.in_step())) {
      told ? log.info("in step with the primary") : log.warn("no longer in step with the primary");
    }
    const Time now = clock.now();
    silent =
        heard || !replica.in_step() ? Time(0) : silent + std::min(now - last, 2 * look_interval);
    last = now;
    stop();
    link.wait(look_interval);
  }
}

Fence::Fence(std::unique_ptr<ZmqServer> server, std::uint64_t generation)
    : server_(std::move(server)), generation_(generation), thread_([this] { lead(); }) {}

Fence::~Fence() {
  quit_ = true;
  thread_.join();
}

void Fence::lead() {
  while (!quit_) {
    answer_all(server_->link(),
               [this](std::string_view message) { return fenced_answer(message, generation_); });
    server_->link().wait(look_interval);
  }
}

}  // namespace parray::replica
