#include "coordinator/replica/replica_thread.h"

#include <algorithm>
#include <utility>

#include "proto/clock.h"

namespace parray::replica {

/// How often what is asked is repeated, and how often the primary says that it lives.
static constexpr Time beat = seconds(1);

static Time time_of(std::size_t bytes) {
  constexpr std::size_t bytes_per_microsecond = 10;
  return std::chrono::microseconds(bytes / bytes_per_microsecond);
}

ReplicaThread::ReplicaThread(std::unique_ptr<Link> link, std::string address)
    : link_(std::move(link)), address_(std::move(address)), thread_([this] { lead(); }) {}

ReplicaThread::~ReplicaThread() {
  {
    const std::scoped_lock lock(mutex_);
    quit_ = true;
  }
  link_->wake();
  thread_.join();
}

std::optional<ReplicaReply> ReplicaThread::ask(ReplicaRequest ask) {
  std::unique_lock lock(mutex_);
  ask.number = ++number_;
  ping_ = {ask.session, 0, ReplicaRequestKind::ping, ask.position};
  session_lost_ = false;
  answer_.reset();
  waiting_ = encode(ask);
  send_at_ = Time(0);
  const Time patience = (silent_ ? milliseconds(300) : seconds(3)) + time_of(waiting_.size());
  link_->wake();
  silent_ = !changed_.wait_for(lock, patience, [this] { return answer_ || failure_; });
  waiting_.clear();
  if (failure_) {
    std::rethrow_exception(failure_);
  }
  return std::exchange(answer_, {});
}

bool ReplicaThread::session_lost() const {
  const std::scoped_lock lock(mutex_);
  return session_lost_;
}

bool ReplicaThread::fenced() const {
  const std::scoped_lock lock(mutex_);
  return fenced_;
}

void ReplicaThread::lead() {
  const SteadyClock clock;
  try {
    for (;;) {
      {
        const std::scoped_lock lock(mutex_);
        if (quit_) {
          return;
        }
        work(clock.now());
      }
      constexpr Time nap = milliseconds(100);
      link_->wait(nap);
    }
  } catch (...) {
    const std::scoped_lock lock(mutex_);
    failure_ = std::current_exception();
  }
  changed_.notify_all();
}

/// With the lock. The link never blocks.
void ReplicaThread::work(Time now) {
  while (const auto delivery = link_->receive()) {
    const Frames frames = delivery->content.frames();
    try {
      take(decode_reply(frames.size() == 1 ? frames[0].view() : std::string_view()));
    } catch (const DecodeError&) {
      continue;  // as if it were lost: it comes again
    }
  }
  if (!waiting_.empty() && send_at_ <= now) {
    link_->send({}, Frames{Frame(waiting_)});
    send_at_ = now + beat + time_of(waiting_.size());
  }
  if (ping_.session != 0 && (ping_at_ == never || ping_at_ <= now)) {
    link_->send({}, Frames{Frame(encode(ping_))});
    ping_at_ = now + beat;
  }
}

void ReplicaThread::take(const ReplicaReply& answer) {
  if (answer.session != ping_.session) {
    return;
  }
  silent_ = false;
  fenced_ = fenced_ || answer.kind == ReplicaReplyKind::fenced;
  if (answer.number == 0) {
    session_lost_ = session_lost_ || answer.kind == ReplicaReplyKind::who;
  } else if (answer.number == number_ && !waiting_.empty()) {
    waiting_.clear();
    answer_ = answer;
    changed_.notify_all();
  }
}

}  // namespace parray::replica
