#include "proto/inproc_link.h"

#include <condition_variable>
#include <deque>

namespace parray::proto {

/// A bounded queue of messages with a waiting reader.
class InprocHub::Mailbox {
 public:
  bool put(Delivery delivery) {
    {
      const std::scoped_lock lock(mutex_);
      if (queue_.size() >= most_waiting) return false;
      queue_.push_back(std::move(delivery));
    }
    changed_.notify_one();
    return true;
  }

  std::optional<Delivery> get() {
    const std::scoped_lock lock(mutex_);
    if (queue_.empty()) return {};
    Delivery delivery = std::move(queue_.front());
    queue_.pop_front();
    return delivery;
  }

  void wait(Time timeout) {
    std::unique_lock lock(mutex_);
    changed_.wait_for(lock, timeout, [this] { return woken_ || !queue_.empty(); });
    woken_ = false;
  }

  void wake() noexcept {
    {
      const std::scoped_lock lock(mutex_);
      woken_ = true;
    }
    changed_.notify_one();
  }

 private:
  static constexpr std::size_t most_waiting = 1000;

  std::mutex mutex_;  // guards the next two members
  std::deque<Delivery> queue_;
  bool woken_ = false;
  std::condition_variable changed_;
};

class InprocHub::CoordinatorEnd final : public Link {
 public:
  explicit CoordinatorEnd(InprocHub& hub) : hub_(hub) {}

  [[nodiscard]] Envelope seal(Message message) const override { return message; }
  bool send(const PeerId& to, Envelope content) override {
    std::shared_ptr<Mailbox> mailbox;
    {
      const std::scoped_lock lock(hub_.mutex_);
      const auto found = hub_.peers_.find(to);
      if (found == hub_.peers_.end()) return false;
      mailbox = found->second;
    }
    return mailbox->put({{}, std::move(content)});
  }
  std::optional<Delivery> receive() override { return hub_.inbox_->get(); }
  void wait(Time timeout) override { hub_.inbox_->wait(timeout); }
  void wake() noexcept override { hub_.inbox_->wake(); }

 private:
  InprocHub& hub_;
};

class InprocHub::PeerEnd final : public Link {
 public:
  PeerEnd(InprocHub& hub, PeerId id, std::shared_ptr<Mailbox> mailbox, Sender sender, bool encodes)
      : hub_(hub),
        id_(std::move(id)),
        mailbox_(std::move(mailbox)),
        sender_(std::move(sender)),
        encodes_(encodes) {}
  ~PeerEnd() override {
    const std::scoped_lock lock(hub_.mutex_);
    hub_.peers_.erase(id_);
  }
  PeerEnd& operator=(PeerEnd&&) = delete;

  [[nodiscard]] Envelope seal(Message message) const override {
    return encodes_ ? Link::seal(std::move(message)) : Envelope(std::move(message));
  }
  bool send(const PeerId& /*to*/, Envelope content) override {
    const bool taken = hub_.inbox_->put({id_, std::move(content), sender_});
    if (hub_.on_arrival_) hub_.on_arrival_();
    return taken;
  }
  std::optional<Delivery> receive() override { return mailbox_->get(); }
  void wait(Time timeout) override { mailbox_->wait(timeout); }
  void wake() noexcept override { mailbox_->wake(); }

 private:
  InprocHub& hub_;
  PeerId id_;
  std::shared_ptr<Mailbox> mailbox_;
  Sender sender_;
  bool encodes_;
};

InprocHub::InprocHub(std::function<void()> on_arrival)
    : on_arrival_(std::move(on_arrival)),
      inbox_(std::make_shared<Mailbox>()),
      coordinator_(std::make_unique<CoordinatorEnd>(*this)) {}

InprocHub::~InprocHub() = default;

Link& InprocHub::coordinator() { return *coordinator_; }

std::unique_ptr<Link> InprocHub::add_peer(Sender sender, bool encodes) {
  const std::scoped_lock lock(mutex_);
  const PeerId id = "inproc-" + std::to_string(next_id_++);
  auto mailbox = std::make_shared<Mailbox>();
  peers_.emplace(id, mailbox);
  return std::make_unique<PeerEnd>(*this, id, std::move(mailbox), std::move(sender), encodes);
}

std::unique_ptr<Link> InprocHub::connect() {
  Sender sender;
  sender.ours = true;
  return add_peer(std::move(sender), false);
}

std::unique_ptr<Link> InprocHub::connect_as(Sender sender) {
  return add_peer(std::move(sender), true);
}

}  // namespace parray::proto
