#pragma once

#include <array>
#include <cstdint>
#include <nlohmann/json.hpp>
#include <optional>
#include <stdexcept>
#include <string>
#include <utility>
#include <variant>
#include <vector>

#include "common/scene/scene_chunks.h"
#include "common/scene/settings_fwd.h"
#include "common/schedule/cell_grid.h"
#include "proto/frame.h"
#include "proto/job_head.h"
#include "proto/parcels.h"

/// The messages of PROTOCOL.md, as structs. Ranges, answers and meaning stand there.
namespace parray::proto {

inline constexpr std::uint32_t protocol_version = 6;

/// Raised with every change to the bits of a picture: to those of a sample, or to how many samples
/// a pixel gets. scenes/pictures/renew makes the shipped pictures anew then.
inline constexpr std::uint32_t trace_version = 5;

namespace msg {

struct Hello {
  std::uint32_t version = protocol_version;
  std::string name;
  std::string instance;
  std::uint32_t threads = 1;
  std::uint32_t capacity = 2;
  std::uint32_t trace = trace_version;
  std::string fingerprint;
  std::string host{};            ///< its machine's name; workers of one share what has come there
  std::uint32_t share_port = 0;  ///< where it hands on chunks of scenes; 0: it does not
  std::string share_key{};       ///< CURVE key of that port
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
  std::uint32_t pass = 0;
  std::uint64_t epoch = 0;
  CellBatch cells;
  std::string scene;
  Boxed<RenderSettings> settings;
  /// Seconds after which the worker is to hand in what it has traced of the lease; 0: all of it.
  double longest = 0;
};
/// `failed` of a worker that wants nobody but the coordinator as its source.
inline constexpr std::uint32_t every_source = 1000;
struct NeedScene {
  std::string scene;
  std::uint32_t failed = 0;  ///< sources that have been of no use
};
struct SceneSource {
  std::string scene;
  ChunkCut cut;
  std::string address{};  ///< empty: the coordinator
  std::string key{};
  /// In one process the scene itself. Does not travel.
  std::shared_ptr<const Scene> here{};
};
struct NeedChunk {
  std::string scene;
  std::uint32_t chunk = 0;
};
struct Chunk {
  std::string scene;
  std::uint32_t chunk = 0;
  bool packed = false;  ///< see pack_chunk()
  Bulk content{};
};
struct ChunkLater {
  std::string scene;
  std::uint32_t chunk = 0;
};
struct NoScene {
  std::string scene;
};
struct Result {
  std::uint64_t job = 0;
  std::uint64_t epoch = 0;
  double seconds = 0;
  double build_seconds = 0;
  std::uint64_t accelerator_bytes = 0;
  std::string isa;
  CellsParcel cells;
  /// How many cells, from the lease's first on; 0: all.
  std::uint64_t count = 0;
  /// Of the batch: what `cells` are packed by. Does not travel.
  std::shared_ptr<const CellGrid> grid{};
};
struct Failed {
  std::uint64_t job = 0;
  std::uint64_t epoch = 0;
  std::string reason;
};
enum class Verdict : std::uint8_t { accepted, duplicate, stale, mismatch };
struct ResultVerdict {
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

struct Submit : JobHead {
  std::uint64_t request = 0;
  std::string token;
  SceneParcel scene;
  std::string user;  ///< counts only where there are no keys to tell
};
struct Submitted {
  std::uint64_t request = 0;
  std::uint64_t job = 0;
};
/// Entries of a list that one answer may have.
inline constexpr std::uint32_t most_listed = 1000;
struct ListJobs {
  std::uint64_t request = 0;
  std::uint64_t before = 0;           ///< only jobs of lower numbers; 0: all
  std::uint32_t limit = most_listed;  ///< the newest of them
  std::string states{};               ///< names with commas between; empty: any
};
struct Jobs {
  std::uint64_t request = 0;
  nlohmann::json jobs;
};
struct ShowJob {
  std::uint64_t request = 0;
  std::uint64_t job = 0;
  std::uint32_t from_frame = 0;  ///< of a series: the first frame that is listed
};
struct Job {
  std::uint64_t request = 0;
  nlohmann::json job;
};
enum class JobAction : std::uint8_t { pause, resume, cancel, requeue, forget, prioritise };
struct SteerJob {
  std::uint64_t request = 0;
  std::uint64_t job = 0;
  JobAction action = JobAction::pause;
  std::uint32_t priority = 50;  ///< of `prioritise`
};
struct Fetch {
  std::uint64_t request = 0;
  std::uint64_t job = 0;
  bool partial = false;     ///< what there is of a job that is not done, too
  bool statistics = false;  ///< sample counts and half-widths, too
  bool replicates = false;  ///< these and the halves of the samples
};
struct ImageData {
  std::uint64_t request = 0;
  nlohmann::json report;
  std::uint32_t width = 0;
  std::uint32_t height = 0;
  bool statistics = false;
  bool replicates = false;
  PictureParcel picture;
};
/// What of the picture is in it.
PictureDetail detail_of(const ImageData& message);
struct FetchJournal {
  std::uint64_t request = 0;
  std::uint64_t job = 0;
};
struct JournalData {
  std::uint64_t request = 0;
  nlohmann::json job;
  nlohmann::json report;  ///< of a job that is done
  Bulk journal;           ///< coordinator/jobs/journal.h
};
struct ListWorkers {
  std::uint64_t request = 0;
  std::uint32_t offset = 0;
  std::uint32_t limit = most_listed;
};
enum class WorkerAction : std::uint8_t { drain, readmit };
struct SteerWorkers {
  std::uint64_t request = 0;
  WorkerAction action = WorkerAction::drain;
  bool host = false;  ///< `name` is that of a host: all workers there
  std::string name;
};
struct Workers {
  std::uint64_t request = 0;
  nlohmann::json workers;
  std::uint64_t total = 0;  ///< of workers; more than are listed, perhaps
};
struct ShowFarm {
  std::uint64_t request = 0;
};
struct Farm {
  std::uint64_t request = 0;
  nlohmann::json farm;
};
struct Error {
  std::uint64_t request = 0;
  std::uint32_t status = 1;
  std::string message;
  bool later = false;  ///< there is no room now; the same request may succeed later
};

}  // namespace msg

using Message =
    std::variant<msg::Hello, msg::Welcome, msg::Refuse, msg::Heartbeat, msg::Pulse, msg::Who,
                 msg::Grant, msg::NeedScene, msg::SceneSource, msg::NeedChunk, msg::Chunk,
                 msg::ChunkLater, msg::NoScene, msg::Result, msg::Failed, msg::ResultVerdict,
                 msg::Revoke, msg::Bye, msg::Submit, msg::Submitted, msg::ListJobs, msg::Jobs,
                 msg::ShowJob, msg::Job, msg::SteerJob, msg::Fetch, msg::ImageData,
                 msg::FetchJournal, msg::JournalData, msg::ListWorkers, msg::SteerWorkers,
                 msg::Workers, msg::ShowFarm, msg::Farm, msg::Error>;

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

/// As they travel, in the order of the enumerations.
inline constexpr std::array<std::string_view, 4> verdict_names = {"accepted", "duplicate", "stale",
                                                                  "mismatch"};
inline constexpr std::array<std::string_view, 6> job_action_names = {
    "pause", "resume", "cancel", "requeue", "forget", "prioritise"};
inline constexpr std::array<std::string_view, 2> worker_action_names = {"drain", "readmit"};

}  // namespace parray::proto
