#pragma once

#include <cstdint>
#include <functional>
#include <limits>
#include <memory>
#include <optional>
#include <random>
#include <string>
#include <utility>
#include <vector>

#include "coordinator/replica/replica.h"
#include "coordinator/replica/replicated_store.h"
#include "tests/support/rooms.h"

namespace parray::test {

/// A standby behind a connection that loses, repeats, delays and cuts messages.
class Standby final : public ReplicaConnection {
 public:
  explicit Standby(Store& store, double badness = 0, std::uint64_t seed = 1)
      : store_(&store), badness_(badness), random_(seed) {
    restart();
  }

  void restart() { replica_ = std::make_unique<Replica>(*store_, overwrite); }
  bool overwrite = false;
  /// Replaces the standby by another one at the same address.
  void become(Store& store) {
    store_ = &store;
    restart();
  }
  [[nodiscard]] Replica& replica() { return *replica_; }
  void heal() { badness_ = 0; }
  bool cut_off = false;  ///< nothing arrives
  int calls = 0;
  int last_call = std::numeric_limits<int>::max();  ///< the connection is cut after this call

  std::optional<ReplicaReply> call(ReplicaRequest request) override {
    ++calls;
    cut_off = cut_off || calls > last_call;
    request.number = ++number_;
    ping_ = {request.session, 0, ReplicaRequestKind::ping, request.position};
    constexpr int most_repeats = 4;
    for (int i = 0; i < most_repeats && !cut_off; ++i) {
      if (const auto answer = carry(encode(request)); answer && answer->number == number_) {
        return answer;
      }
    }
    return std::nullopt;
  }
  [[nodiscard]] bool session_lost() const override {
    return !cut_off &&
           decode_reply(replica_->answer(encode(ping_))).kind == ReplicaReplyKind::unknown_session;
  }
  [[nodiscard]] const std::string& address() const override { return address_; }

 private:
  bool chance() { return std::uniform_real_distribution<>(0, 1)(random_) < badness_; }

  std::optional<ReplicaReply> carry(std::string message) {
    if (chance()) late_.push_back(message);
    if (chance()) {
      return std::nullopt;  // lost on the way there
    }
    if (chance()) message.resize(random_() % message.size());
    if (chance() && !late_.empty()) replica_->answer(late_[random_() % late_.size()]);
    if (chance()) replica_->answer(message);
    const std::string answer = replica_->answer(message);
    if (answer.empty() || chance()) {
      return std::nullopt;  // lost on the way back
    }
    return decode_reply(answer);
  }

  Store* store_;
  double badness_;
  std::mt19937_64 random_;
  std::unique_ptr<Replica> replica_;
  std::vector<std::string> late_;
  std::uint64_t number_ = 0;
  ReplicaRequest ping_;
  const std::string address_ = "tcp://standby:7401";
};

/// Random numbers, the same for each seed.
inline std::function<std::uint64_t()> numbers(std::uint64_t seed) {
  return [random = std::make_shared<std::mt19937_64>(seed)] { return (*random)(); };
}

}  // namespace parray::test
