#pragma once

#include <cstdint>
#include <deque>
#include <list>
#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "proto/link.h"
#include "worker/scene_opener.h"

namespace parray::worker {

/// How scenes come to a worker and go on to others, its side of PROTOCOL.md: asks the coordinator
/// for a source, pulls chunk after chunk from there, some at a time, and hands what it has to
/// whoever asks, while later ones are still to come. A source that is silent, or stands still, is
/// exchanged for another; the chunks that have come are kept. Plain state, driven by one thread.
class SceneExchange {
 public:
  /// `wake`: see SceneOpener.
  explicit SceneExchange(const std::function<void()>& wake) : opener_(wake) {}

  /// The scene that is needed now; empty: none. What was needed before is given up, but for the
  /// chunks that have come.
  void want(const std::string& scene);
  /// A scene that was wanted, once.
  std::optional<OpenedScene> take_opened();

  /// False: it is a message about something else. `from`: empty for the coordinator.
  bool receive(Time now, const PeerId& from, Message& message);
  /// Returns when it is due again.
  Time tick(Time now);
  /// Messages to send, in order; empties the outbox.
  std::vector<Delivery> take_outbox() { return std::exchange(outbox_, {}); }

  struct Tally {
    std::uint64_t scenes = 0;  ///< that have come
    Time took{};               ///< the last one, on its way
    /// Bytes of chunks, and so on.
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

  /// Chunks of a scene.
  struct Holding {
    ScenePieces content;
    std::uint32_t have = 0;
    Time used{};

    [[nodiscard]] bool complete() const { return have > 0 && have == content.cut.count(); }
  };
  /// Of the scene that is wanted.
  struct Fetch {
    std::string scene;
    std::uint32_t failed = 0;  ///< sources
    Time began = never;
    std::optional<PeerId> source;  ///< none: the coordinator is asked for one
    Time ask_at = Time::min();     ///< it again
    Time heard{};                  ///< anything from the source
    Time progressed{};             ///< a chunk
    Time quiet{};                  ///< so long before what is in flight is asked for again
    std::map<std::uint32_t, Time> in_flight{};  ///< chunks, and when they were asked for
    bool opening = false;
  };
  /// Somebody who has asked for a chunk before it was here.
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
  void hand_on(Time now, const PeerId& to, Holding& holding, std::uint32_t chunk);
  void send_away();
  void give_source_up(Time now);
  void judge_source(Time now);
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
