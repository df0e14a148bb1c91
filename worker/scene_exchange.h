#pragma once

#include <cstdint>
#include <deque>
#include <functional>
#include <list>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "common/scene/scene.h"
#include "common/scene/scene_chunks.h"
#include "proto/link.h"
#include "worker/task_thread.h"

namespace parray::worker {

/// A chunk as received.
struct ScenePiece {
  bool packed = false;  ///< `content` is the output of pack_chunk()
  Bulk content{};       ///< empty: not received yet

  [[nodiscard]] bool arrived() const { return content.data.size() > 0; }
};

/// All chunks of a scene, as received.
struct ScenePieces {
  std::string id;  ///< scene_identity()
  ChunkCut cut;
  std::vector<ScenePiece> pieces;
};

struct OpenedScene {
  std::string id;
  std::shared_ptr<const Scene> scene;  ///< null: it could not be opened
  /// If the scene is null: why this worker cannot open it. Empty: the pieces are not those of `id`,
  /// so that another source may help.
  std::string failure{};
};

/// Opens scenes from their chunks on a background thread, because large scenes take seconds.
class SceneOpener {
 public:
  /// The background thread calls `wake` when take() has a scene. Without `wake`, start() opens the
  /// scene in the calling thread.
  explicit SceneOpener(const std::function<void()>& wake);

  /// Begins to open a scene, all chunks of which have arrived. Call it only when idle.
  void start(ScenePieces packed);
  [[nodiscard]] bool idle() const { return thread_ ? thread_->idle() : !opened_; }
  /// Returns the opened scene, once.
  std::optional<OpenedScene> take();

 private:
  std::optional<OpenedScene> opened_;  ///< scene opened without a background thread
  std::unique_ptr<TaskThread<ScenePieces, OpenedScene>> thread_;
};

/// Fetches scenes for a worker and hands them on to other workers: its side of PROTOCOL.md. Asks
/// the coordinator for a source and pulls the chunks from it, several at a time. Hands each chunk
/// that it has to any worker that asks, even before later chunks have arrived. If a worker is
/// silent or makes no progress as a source, the exchange replaces it and keeps the chunks received
/// so far. Not thread-safe.
class SceneExchange {
 public:
  /// `wake`: see SceneOpener.
  explicit SceneExchange(const std::function<void()>& wake) : opener_(wake) {}

  /// Sets the scene that is needed now; empty: none. Gives up the fetch of another scene, but keeps
  /// its chunks. Has no effect while a scene is being opened, so call it before each tick().
  void want(const std::string& scene);
  /// Returns an opened scene, once. If opening failed, `scene` is null and `failure` tells why.
  std::optional<OpenedScene> take_opened();

  /// Takes in a message about scenes. Returns false for any other message. `from` is empty for the
  /// coordinator.
  bool receive(Time now, const PeerId& from, Message& message);
  /// Does the work that is due. Returns the time when it is due again.
  Time tick(Time now);
  /// Returns the messages to send, in order, and empties the outbox.
  std::vector<Delivery> take_outbox() { return std::exchange(outbox_, {}); }

  struct Tally {
    std::uint64_t scenes = 0;  ///< scenes received
    Time took{};               ///< time from the first request for the last scene to its last chunk
    /// Bytes of chunks, by source and direction.
    std::uint64_t from_coordinator = 0;
    std::uint64_t from_workers = 0;
    std::uint64_t handed_on = 0;
  };
  [[nodiscard]] const Tally& tally() const { return tally_; }

 private:
  void on(Time now, const PeerId& from, msg::SceneSource& m);
  void on(Time now, const PeerId& from, msg::Chunk& m);
  void on(Time now, const PeerId& from, msg::ChunkLater& m);
  void on(Time now, const PeerId& from, msg::NoScene& m);
  void on(Time now, const PeerId& from, msg::NeedChunk& m);

  /// The chunks of a scene.
  struct Holding {
    ScenePieces content;
    std::uint32_t received = 0;
    Time used{};

    [[nodiscard]] bool complete() const { return received > 0 && received == content.cut.count(); }
  };
  /// The fetch of the wanted scene.
  struct Fetch {
    std::string scene;
    std::uint32_t failed = 0;  ///< number of sources that failed
    Time began = never;
    std::optional<PeerId> source;  ///< none: the coordinator is asked for a source
    Time ask_at = Time::min();     ///< time to ask the coordinator again
    Time heard{};                  ///< time of the last message from the source
    Time progressed{};             ///< time of the last chunk
    /// Silence after which lost chunks are requested again. Without silence: ten times as long.
    Time resend_after{};
    std::map<std::uint32_t, Time> in_flight{};  ///< chunks and the times of their requests
    bool opening = false;
  };
  /// A worker that asked for a chunk before it was here.
  struct Waiting {
    PeerId peer;
    std::string scene;
    std::uint32_t chunk;
  };

  [[nodiscard]] bool is_source(const PeerId& from, const std::string& scene) const;
  Holding* holding_of(const std::string& scene);
  Holding& hold(Time now, const std::string& scene, const ChunkCut& cut);
  void drop(std::string scene);
  void drop_unused(Time now);
  void send(const PeerId& to, Message message) { outbox_.push_back({to, std::move(message)}); }
  void pass_on(Time now, const PeerId& to, Holding& holding, std::uint32_t chunk);
  void answer_waiting_workers();
  void give_source_up(Time now);
  void check_source(Time now);
  void repeat(Time now);
  void pull(Time now);
  void open_if_complete(Time now);
  void note_opened(Time now);

  SceneOpener opener_;
  std::optional<Fetch> fetch_;
  std::list<Holding> holdings_;  ///< the last few
  std::deque<Waiting> waiting_;
  std::deque<OpenedScene> opened_;
  std::vector<Delivery> outbox_;
  Tally tally_;
};

}  // namespace parray::worker
