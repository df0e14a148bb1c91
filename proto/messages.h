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
#include "proto/payloads.h"

/// The messages of PROTOCOL.md, as structs. PROTOCOL.md describes ranges, answers and meaning.
///
/// In all messages, `request` is a number that the answer repeats, `job` is the number of a job,
/// `job` and `epoch` together name a lease, and `scene` of type std::string is the SHA-256 of the
/// scene's bytes. Times of type double are in seconds. Maps (nlohmann::json) are those of
/// PROTOCOL.md, such as a job map.
namespace parray::proto {

inline constexpr std::uint32_t protocol_version = 6;

/// Version of the bits of pictures. Increase it with every change to the bits of a picture, and to
/// the number of samples of a pixel. Then renew the shipped pictures with scenes/pictures/renew.
inline constexpr std::uint32_t trace_version = 6;

namespace msg {

/// Limits of Hello::processors and Hello::memory_bytes.
inline constexpr std::uint32_t most_processors = 65536;
inline constexpr std::uint64_t most_memory_bytes = std::uint64_t{1} << 50;
struct Hello {
  std::uint32_t version = protocol_version;
  std::string name;
  std::string instance;  ///< different for every start of a process
  std::uint32_t threads = 1;
  /// Number of leases that it wants at a time. By default one is traced while another waits, so
  /// that the team never waits for a message. More leases help only if a lease is shorter than a
  /// message's travel time.
  std::uint32_t capacity = 2;
  std::uint32_t trace = trace_version;
  std::string fingerprint;       ///< trace_fingerprint() of the worker's build
  std::string host{};            ///< host name; workers get scenes preferably from their own host
  std::uint32_t share_port = 0;  ///< port for requests of scene chunks; 0: none
  std::string share_key{};       ///< CURVE key of that port
  // Facts for people. Older workers do not send them: then they are empty or 0.
  std::string release{};           ///< version of ParRay
  std::uint32_t processors = 0;    ///< of the machine, as far as the worker may use them
  std::uint64_t memory_bytes = 0;  ///< of the machine, as far as the worker may use it
};
struct Welcome {
  std::uint32_t heartbeat_ms = 1000;
  std::uint32_t silence_ms = 5000;  ///< silence after which each side counts as lost
};
struct Refuse {
  std::string reason;
};
struct Heartbeat {
  std::uint64_t traced = 0;  ///< samples since the worker's start
  bool preparing = false;    ///< it waits for a scene or builds an accelerator
  std::vector<std::pair<std::uint64_t, std::uint64_t>> epochs;  ///< job, epoch
  double load = -1;  ///< load average of the machine over the last minute; negative: not known
};
struct HeartbeatAck {};
/// Asks a worker that the coordinator does not know for a new `hello`.
struct Identify {};
struct Grant {
  std::uint64_t job = 0;
  std::uint32_t pass = 0;
  std::uint64_t epoch = 0;
  CellBatch cells;
  std::string scene;
  Boxed<RenderSettings> settings;
  /// Seconds of tracing after which the worker begins no more cells and returns those that it has
  /// traced, at least one; 0: it returns all.
  double longest = 0;
};
/// Value of NeedScene::failed by which a worker asks for the coordinator itself as the source,
/// because the chunks that it received were not those of the scene.
inline constexpr std::uint32_t every_source = 1000;
struct NeedScene {
  std::string scene;
  std::uint32_t failed = 0;  ///< other workers that failed as source, or every_source
};
struct SceneSource {
  std::string scene;
  ChunkCut cut;
  std::string address{};  ///< tcp://ADDRESS:PORT of a worker; empty: the coordinator
  std::string key{};      ///< the worker's public key (Hello::share_key)
  /// The scene itself, only within one process.
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
/// The source does not have the chunk yet, and will send it without another request.
struct ChunkLater {
  std::string scene;
  std::uint32_t chunk = 0;
};
/// The source cannot send the scene, because it does not have it or has too many requests.
struct NoScene {
  std::string scene;
};
struct Result {
  std::uint64_t job = 0;
  std::uint64_t epoch = 0;
  double seconds = 0;        ///< of tracing
  double build_seconds = 0;  ///< of building the accelerator, possibly for an earlier lease
  std::uint64_t accelerator_bytes = 0;
  std::string isa;  ///< instruction set that traced the cells
  CellsPayload cells;
  /// Number of cells, from the lease's first on; 0: all.
  std::uint64_t count = 0;
  /// Grid of the cells, for packing them. Not part of the encoded message.
  std::shared_ptr<const CellGrid> grid{};
};
/// The worker cannot trace this lease, but continues to run.
struct Failed {
  std::uint64_t job = 0;
  std::uint64_t epoch = 0;
  std::string reason;
};
/// `accepted`: merged into the picture. `duplicate`: same bits as an earlier result. `stale`: the
/// lease has ended, or the result is damaged. `mismatch`: the result differs from an earlier one
/// for the same cells, so it is disputed.
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
  std::string token;  ///< new for every job of a user; a repeated submit makes no second job
  ScenePayload scene;
  std::string user;  ///< ignored if keys identify the user
};
struct Submitted {
  std::uint64_t request = 0;
  std::uint64_t job = 0;
};
/// Maximum number of jobs or workers in a list.
inline constexpr std::uint32_t most_listed = 1000;
/// A list of jobs is sorted by this key. `taken` is the time taken so far. If keys are equal, the
/// newest job comes first.
enum class JobSort : std::uint8_t {
  id,
  name,
  user,
  state,
  priority,
  submitted,
  finished,
  taken,
  progress
};
/// `newest`: the jobs with the highest numbers, in ascending order, whatever JobSort says.
enum class JobOrder : std::uint8_t { newest, ascending, descending };
struct ListJobs {
  std::uint64_t request = 0;
  std::uint64_t before = 0;           ///< lists only jobs with lower numbers; 0: all
  std::uint32_t limit = most_listed;  ///< lists at most so many jobs
  /// States of the jobs, separated by commas; empty: all states.
  std::string states{};
  std::string user{};  ///< lists only jobs of this user; empty: of all
  std::string name{};  ///< only jobs whose name contains this, in any letter case
  JobSort sort = JobSort::id;
  JobOrder order = JobOrder::newest;
  std::uint32_t offset = 0;  ///< skips so many jobs; only with `ascending` or `descending`
};
struct Jobs {
  std::uint64_t request = 0;
  nlohmann::json jobs;
  std::uint64_t total = 0;  ///< jobs that states, user and name select; 0 with `newest`
};
struct ShowJob {
  std::uint64_t request = 0;
  std::uint64_t job = 0;
  std::uint32_t from_frame = 0;  ///< first frame listed of a series
};
struct Job {
  std::uint64_t request = 0;
  nlohmann::json job;
};
/// `pause`: no more leases until `resume`. `requeue`: continue a failed or cancelled job. `forget`:
/// delete a job that has ended.
enum class JobAction : std::uint8_t { pause, resume, cancel, requeue, forget, prioritise };
struct SteerJob {
  std::uint64_t request = 0;
  std::uint64_t job = 0;
  JobAction action = JobAction::pause;
  std::uint32_t priority = 50;  ///< only for `prioritise`
};
/// Maximum number of jobs that one message changes.
inline constexpr std::uint32_t most_steered = 500;
struct SteerJobs {
  std::uint64_t request = 0;
  std::vector<std::uint64_t> jobs;
  JobAction action = JobAction::pause;
  std::uint32_t priority = 50;  ///< only for `prioritise`
};
/// Why a job was not changed: there is no such job, it belongs to another user, the action does not
/// fit its state, or a limit does not permit it to be queued again.
enum class Refusal : std::uint8_t { missing, forbidden, state, no_room };
struct Steered {
  std::uint64_t request = 0;
  /// For each job, in the order of the request: `id`, and either `job`, a short map, or `refusal`
  /// (a word of refusal_names) and `message`.
  nlohmann::json results;
};
struct Fetch {
  std::uint64_t request = 0;
  std::uint64_t job = 0;
  bool partial = false;     ///< accepts the picture of a job that is not done
  bool statistics = false;  ///< asks for sample counts and half-widths, too
  /// Asks for statistics, too, and for the two pictures of the even and of the odd samples, if the
  /// job keeps them. Without effect unless the job is done.
  bool replicates = false;
};
struct ImageData {
  std::uint64_t request = 0;
  nlohmann::json report;
  std::uint32_t width = 0;
  std::uint32_t height = 0;
  bool statistics = false;
  bool replicates = false;
  PicturePayload picture;
};
/// Returns which detail of the picture the message contains.
PictureDetail detail_of(const ImageData& message);
struct FetchJournal {
  std::uint64_t request = 0;
  std::uint64_t job = 0;
};
struct JournalData {
  std::uint64_t request = 0;
  nlohmann::json job;
  nlohmann::json report;  ///< of a done job; otherwise an empty map
  Bulk journal;           ///< see coordinator/jobs/journal.h
};
/// Asks for the scene of a job that is not done, or of a done job with JobHead::keeps_scene().
struct FetchScene {
  std::uint64_t request = 0;
  std::uint64_t job = 0;
};
struct SceneData {
  std::uint64_t request = 0;
  Boxed<RenderSettings> settings;  ///< of the job
  ScenePayload scene;
  std::string drawing{};  ///< JobHead::drawing
};
struct ListWorkers {
  std::uint64_t request = 0;
  std::uint32_t offset = 0;
  std::uint32_t limit = most_listed;
};
/// `drain`: no more leases. `readmit`: leases again.
enum class WorkerAction : std::uint8_t { drain, readmit };
struct SteerWorkers {
  std::uint64_t request = 0;
  WorkerAction action = WorkerAction::drain;
  bool host = false;  ///< `name` is a host and stands for all its workers
  std::string name;
};
struct Workers {
  std::uint64_t request = 0;
  nlohmann::json workers;
  /// After ListWorkers: number of all workers and of quarantined machines without a worker. After
  /// SteerWorkers: length of the list.
  std::uint64_t total = 0;
};
struct ShowFarm {
  std::uint64_t request = 0;
  bool history = false;  ///< asks for the last hour instead of the present state
};
struct Farm {
  std::uint64_t request = 0;
  nlohmann::json farm;
};
struct ShowWorker {
  std::uint64_t request = 0;
  std::string name;
};
struct Worker {
  std::uint64_t request = 0;
  nlohmann::json worker;
};
/// Limits of a `log`: number of lines, and bytes of a line.
inline constexpr std::size_t most_log_lines = 100;
inline constexpr std::size_t most_log_line = 500;
/// Asks for the log of the worker `name`: a client asks the coordinator, which asks the worker.
struct ShowLog {
  std::uint64_t request = 0;
  std::string name;
};
struct Log {
  std::uint64_t request = 0;
  std::vector<std::string> lines;  ///< oldest first
};
struct Error {
  std::uint64_t request = 0;
  std::uint32_t status = 1;  ///< exit status of the client: 1 failed, 2 bad input
  std::string message;
  bool later = false;  ///< no room now: the same request may succeed later
};

}  // namespace msg

using Message = std::variant<
    msg::Hello, msg::Welcome, msg::Refuse, msg::Heartbeat, msg::HeartbeatAck, msg::Identify,
    msg::Grant, msg::NeedScene, msg::SceneSource, msg::NeedChunk, msg::Chunk, msg::ChunkLater,
    msg::NoScene, msg::Result, msg::Failed, msg::ResultVerdict, msg::Revoke, msg::Bye, msg::Submit,
    msg::Submitted, msg::ListJobs, msg::Jobs, msg::ShowJob, msg::Job, msg::SteerJob, msg::SteerJobs,
    msg::Steered, msg::Fetch, msg::ImageData, msg::FetchJournal, msg::JournalData, msg::ListWorkers,
    msg::SteerWorkers, msg::Workers, msg::ShowFarm, msg::Farm, msg::ShowWorker, msg::Worker,
    msg::ShowLog, msg::Log, msg::Error, msg::FetchScene, msg::SceneData>;

/// The message is malformed. `request` is set if it was readable, so that the client gets an
/// `error`.
class ProtocolError : public std::runtime_error {
 public:
  explicit ProtocolError(const std::string& what, std::optional<std::uint64_t> request = {})
      : std::runtime_error(what), request_(request) {}
  [[nodiscard]] std::optional<std::uint64_t> request() const { return request_; }

 private:
  std::optional<std::uint64_t> request_;
};

/// Encodes a message. Never fails for values within the ranges of PROTOCOL.md.
Frames encode(const Message& message);

/// Decodes a message and checks every bound and range. If a `hello` has another protocol version,
/// reads only that version and leaves the other fields at their defaults. Throws ProtocolError, and
/// no other exception, for malformed frames.
Message decode(const Frames& frames);

/// The words of the encoded messages, in the order of the enumerations.
inline constexpr std::array<std::string_view, 4> verdict_names = {"accepted", "duplicate", "stale",
                                                                  "mismatch"};
inline constexpr std::array<std::string_view, 6> job_action_names = {
    "pause", "resume", "cancel", "requeue", "forget", "prioritise"};
inline constexpr std::array<std::string_view, 9> job_sort_names = {
    "id", "name", "user", "state", "priority", "submitted", "finished", "taken", "progress"};
inline constexpr std::array<std::string_view, 3> job_order_names = {"newest", "asc", "desc"};
inline constexpr std::array<std::string_view, 4> refusal_names = {"missing", "forbidden", "state",
                                                                  "no_room"};
inline constexpr std::array<std::string_view, 2> worker_action_names = {"drain", "readmit"};

}  // namespace parray::proto
