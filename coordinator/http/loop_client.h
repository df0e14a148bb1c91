#pragma once

#include <atomic>
#include <memory>
#include <type_traits>
#include <utility>
#include <variant>

#include "common/base/printable.h"
#include "coordinator/http/exchange.h"
#include "proto/inproc_link.h"

namespace parray::http {

/// Whether ask() waits for the answer to this request up to 60 seconds, because the loop may have
/// to read or write files first.
template <typename Asked>
inline constexpr bool waits_for_disk =
    std::is_same_v<Asked, msg::Submit> || std::is_same_v<Asked, msg::Fetch> ||
    std::is_same_v<Asked, msg::FetchScene> || std::is_same_v<Asked, msg::FetchJournal> ||
    std::is_same_v<Asked, msg::SteerJob> || std::is_same_v<Asked, msg::SteerJobs> ||
    std::is_same_v<Asked, msg::SteerWorkers>;

/// Sends requests to the coordinator's loop, as any client does, with the messages of PROTOCOL.md.
/// Callable from any thread.
class LoopClient {
 public:
  /// `hub` must outlive this object.
  explicit LoopClient(InprocHub& hub) : hub_(hub) {}

  /// Sends one request of `sender`, repeats it every 0.5 s, and returns the answer. Throws Problem
  /// with the loop's message: 409 if the request was wrong, 503 if the loop asks to try later, 500
  /// otherwise. Also throws Problem 503 if no answer arrives within 10 seconds (60 seconds for
  /// scenes, pictures, journals and changes, which wait for the disk).
  template <typename Answer, typename Asked>
  Answer ask(const Sender& sender, Asked request) {
    constexpr Time patience = waits_for_disk<Asked> ? seconds(60) : seconds(10);
    constexpr Time repeat = milliseconds(500);
    constexpr Time nap = milliseconds(50);
    const std::unique_ptr<Link> link = hub_.connect_as(sender);
    request.request = 1;
    const Envelope sealed = link->seal(Message(std::move(request)));
    const SteadyClock clock;
    const Time begin = clock.now();
    Time send_at = begin;
    for (Time now = begin; now - begin < patience && !stopped_; now = clock.now()) {
      if (now >= send_at) {
        link->send({}, sealed);
        send_at = now + repeat;
      }
      link->wait(nap);
      while (auto delivery = link->receive()) {
        Message message = delivery->content.open();
        if (auto* answer = std::get_if<Answer>(&message)) return std::move(*answer);
        if (const auto* error = std::get_if<msg::Error>(&message)) {
          const int status = error->later ? 503 : error->status == 2 ? 409 : 500;
          throw Problem(status, printable(error->message, 2000), static_cast<int>(error->status));
        }
      }
    }
    throw Problem(503, stopped_ ? "the coordinator is stopping: try again later"
                                : "the coordinator does not answer: try again later");
  }

  /// Makes all current and later requests fail with Problem 503.
  void stop() { stopped_ = true; }

 private:
  InprocHub& hub_;
  std::atomic<bool> stopped_ = false;
};

}  // namespace parray::http
