#pragma once

#include <cstdint>
#include <nlohmann/json.hpp>
#include <optional>
#include <stdexcept>
#include <string>
#include <utility>
#include <variant>
#include <vector>

#include "common/image/row_block.h"
#include "common/scene/settings.h"
#include "proto/link.h"

/// The messages of PROTOCOL.md, as structs. Ranges, answers and meaning stand there.
namespace parray {

inline constexpr std::uint32_t protocol_version = 1;

/// Raised with every change to the bits of a sample.
inline constexpr std::uint32_t trace_version = 3;

namespace msg {

struct Hello {
  std::uint32_t version = protocol_version;
  std::string name;
  std::string instance;
  std::uint32_t threads = 1;
  std::uint32_t capacity = 2;
  std::uint32_t trace = trace_version;
  std::string fingerprint;
};
struct Welcome {
  std::uint32_t heartbeat_ms = 1000;
  std::uint32_t silence_ms = 5000;
};
struct Refuse {
  std::string reason;
};
struct Heartbeat {
  std::uint64_t traced = 0;
  bool preparing = false;
  std::vector<std::pair<std::uint64_t, std::uint64_t>> epochs;  ///< job, epoch
};
struct Pulse {};
struct Who {};
struct Grant {
  std::uint64_t job = 0;
  std::uint64_t epoch = 0;
  WorkRect rect;
  std::string scene;
  RenderSettings settings;
  /// Which of the rectangle's samples each of its pixels has, position order; empty: all.
  std::vector<SampleRange> samples{};
};
struct NeedScene {
  std::string scene;
};
struct SceneData {
  std::string scene;
  std::string bytes;
};
struct Result {
  std::uint64_t job = 0;
  std::uint64_t epoch = 0;
  double seconds = 0;
  double build_seconds = 0;
  std::uint64_t accelerator_bytes = 0;
  std::string isa;
  RowBlock block;
};
enum class Verdict : std::uint8_t { accepted, duplicate, stale, mismatch };
struct VerdictOf {
  std::uint64_t job = 0;
  std::uint64_t epoch = 0;
  Verdict verdict = Verdict::accepted;
};
struct Revoke {
  std::uint64_t job = 0;
  std::uint64_t epoch = 0;
};
struct Bye {
  std::string reason;
};

struct Submit {
  std::uint64_t request = 0;
  std::string token;
  std::string name;
  std::uint32_t priority = 50;
  RenderSettings settings;
  std::string precision_reason;
  double load_seconds = 0;
  std::string scene_bytes;
  std::uint64_t duplicates_removed = 0;
};
struct Submitted {
  std::uint64_t request = 0;
  std::uint64_t job = 0;
};
struct ListJobs {
  std::uint64_t request = 0;
};
struct Jobs {
  std::uint64_t request = 0;
  nlohmann::json jobs;
};
struct ShowJob {
  std::uint64_t request = 0;
  std::uint64_t job = 0;
};
struct Job {
  std::uint64_t request = 0;
  nlohmann::json job;
};
struct Cancel {
  std::uint64_t request = 0;
  std::uint64_t job = 0;
};
struct Fetch {
  std::uint64_t request = 0;
  std::uint64_t job = 0;
  bool partial = false;     ///< what there is of a job that is not done, too
  bool statistics = false;  ///< sample counts and half-widths, too
};
struct ImageData {
  std::uint64_t request = 0;
  nlohmann::json report;
  std::uint32_t width = 0;
  std::uint32_t height = 0;
  bool statistics = false;
  std::string pixels;  ///< see common/image/picture_bytes.h
};
struct ListWorkers {
  std::uint64_t request = 0;
};
struct Workers {
  std::uint64_t request = 0;
  nlohmann::json workers;
};
struct Error {
  std::uint64_t request = 0;
  std::uint32_t status = 1;
  std::string message;
};

}  // namespace msg

using Message =
    std::variant<msg::Hello, msg::Welcome, msg::Refuse, msg::Heartbeat, msg::Pulse, msg::Who,
                 msg::Grant, msg::NeedScene, msg::SceneData, msg::Result, msg::VerdictOf,
                 msg::Revoke, msg::Bye, msg::Submit, msg::Submitted, msg::ListJobs, msg::Jobs,
                 msg::ShowJob, msg::Job, msg::Cancel, msg::Fetch, msg::ImageData, msg::ListWorkers,
                 msg::Workers, msg::Error>;

/// The message is malformed. `request` is set if it could still be read, so that a client can be
/// told.
class ProtocolError : public std::runtime_error {
 public:
  explicit ProtocolError(const std::string& what, std::optional<std::uint64_t> request = {})
      : std::runtime_error(what), request_(request) {}
  [[nodiscard]] std::optional<std::uint64_t> request() const { return request_; }

 private:
  std::optional<std::uint64_t> request_;
};

/// Frames of a message. Never fails for values within the ranges of PROTOCOL.md.
Frames encode(const Message& message);

/// Inverse of encode(). Every bound and range is checked before it is relied on. Throws
/// ProtocolError, and nothing else, for any bytes.
Message decode(const Frames& frames);

/// The bytes of a row block in PROTOCOL.md's layout, and back (throws DecodeError).
std::string row_block_to_bytes(const RowBlock& block);
RowBlock row_block_from_bytes(std::string_view bytes);

/// XXH3-64 of some bytes: tells whether two results are equal.
std::uint64_t digest_of(std::string_view bytes);

std::string_view name_of(msg::Verdict verdict);

}  // namespace parray
