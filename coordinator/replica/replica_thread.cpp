#include "coordinator/replica/replica_thread.h"

#include <utility>

#include "proto/clock.h"

namespace parray::replica {

/// Time between two sends of a request, and between two pings.
static constexpr Time repeat_interval = seconds(1);

static Time transfer_time(std::size_t bytes) {
  constexpr std::size_t bytes_per_microsecond = 10;
  return std::chrono::microseconds(bytes / bytes_per_microsecond);
}

ReplicaThread::ReplicaThread(std::unique_ptr<Link> link, std::string address)
    : link_(std::move(link)), address_(std::move(address)), thread_([this] { run(); }) {}

ReplicaThread::~ReplicaThread() {
  {
    const std::scoped_lock lock(mutex_);
    quit_ = true;
  }
  link_->wake();
  thread_.join();
}

std::optional<ReplicaReply> ReplicaThread::call(ReplicaRequest request) {
  std::unique_lock lock(mutex_);
  request.number = ++number_;
  ping_ = {request.session, 0, ReplicaRequestKind::ping, request.position};
  session_lost_ = false;
  answer_.reset();
  request_ = encode(request);
  send_at_ = Time(0);
  const Time patience = (silent_ ? milliseconds(300) : seconds(3)) + transfer_time(request_.size());
  link_->wake();
  silent_ = !changed_.wait_for(lock, patience, [this] { return answer_ || failure_; });
  request_.clear();
  if (failure_) std::rethrow_exception(failure_);
  return std::exchange(answer_, {});
}

void ReplicaThread::run() {
  const SteadyClock clock;
  try {
    for (;;) {
      {
        const std::scoped_lock lock(mutex_);
        if (quit_) return;
        exchange_messages(clock.now());
      }
      constexpr Time wait_time = milliseconds(100);
      link_->wait(wait_time);
    }
  } catch (...) {
    const std::scoped_lock lock(mutex_);
    failure_ = std::current_exception();
  }
  changed_.notify_all();
}

/// Receives replies, repeats the request and pings. The caller holds the lock.
void ReplicaThread::exchange_messages(Time now) {
  while (const auto delivery = link_->receive()) {
    const Frames frames = delivery->content.frames();
    try {
      accept_reply(decode_reply(frames.size() == 1 ? frames[0].view() : std::string_view()));
    } catch (const DecodeError&) {
      continue;  // the request is repeated
    }
  }
  if (!request_.empty() && send_at_ <= now) {
    link_->send({}, Frames{Frame(request_)});
    send_at_ = now + repeat_interval + transfer_time(request_.size());
  }
  if (ping_.session != 0 && (ping_at_ == never || ping_at_ <= now)) {
    link_->send({}, Frames{Frame(encode(ping_))});
    ping_at_ = now + repeat_interval;
  }
}

void ReplicaThread::accept_reply(const ReplicaReply& answer) {
  if (answer.session != ping_.session) return;
  silent_ = false;
  fenced_ = fenced_ || answer.kind == ReplicaReplyKind::fenced;
  if (answer.number == 0) {
    session_lost_ = session_lost_ || answer.kind == ReplicaReplyKind::unknown_session;
  } else if (answer.number == number_ && !request_.empty()) {
    request_.clear();
    answer_ = answer;
    changed_.notify_all();
  }
}

}  // namespace parray::replica
