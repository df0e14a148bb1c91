#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>

#include "proto/link.h"

namespace parray::proto {

struct ZmqMeshOptions {
  std::string coordinator;  ///< addresses, as zmq_connect() has them
  std::size_t max_message_bytes = 0;
  Time linger = seconds(1);        ///< of what the coordinator has not got yet
  std::optional<MemberKey> key{};  ///< for the coordinator
  bool sharing = true;
};

/// A worker's connections: to the coordinator, whose id is empty, and to other workers, with which
/// it shares scenes. What it hands on is encrypted with a key that is made for this process, so
/// that only whom the coordinator has told the key can be sure of whom they ask; everybody may ask.
///
/// One connection to a worker that is asked is kept: sending to another one closes it.
class ZmqMesh final : public Link {
 public:
  /// Throws InputError when the coordinator's address is none.
  explicit ZmqMesh(const ZmqMeshOptions& options);
  ~ZmqMesh() override;
  ZmqMesh(const ZmqMesh&) = delete;
  ZmqMesh& operator=(const ZmqMesh&) = delete;

  /// Where other workers may ask this one, on loopback if the coordinator is there, else on all of
  /// the machine's addresses. 0: nowhere.
  [[nodiscard]] std::uint32_t port() const;
  /// Its public key; empty where there is no port.
  [[nodiscard]] const std::string& key() const;

  bool send(const PeerId& to, Envelope content) override;
  std::optional<Delivery> receive() override;
  void wait(Time timeout) override;
  void wake() noexcept override;

 private:
  class Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace parray::proto
