#pragma once

#include <cstdint>
#include <deque>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "coordinator/loop/worker_registry.h"
#include "proto/messages.h"

namespace parray::coordinator {

/// Decides from which source each worker gets a scene. If workers can serve each other, the
/// coordinator sends it only a few times, and it crosses the network once per machine. The workers
/// of a scene form a tree in the order of their first requests. A source always asked earlier than
/// the worker that it serves, so there are no cycles. Not thread-safe.
class SceneService {
 public:
  /// The coordinator serves so many machines before workers serve each other. A worker serves at
  /// most so many workers of other machines, and so many of its own machine.
  static constexpr std::uint32_t fan_out = 2;

  /// `chunk_bytes`: size of all chunks except the last.
  explicit SceneService(std::uint32_t chunk_bytes = usual_chunk_bytes)
      : chunk_bytes_(chunk_bytes) {}

  /// Returns the source from which `worker` should get `scene`, which has `bytes` bytes. `failed`
  /// is the field of `need_scene`: if it has grown, the previous source failed.
  msg::SceneSource source_for(const WorkerRecord& worker, const std::string& scene,
                              std::uint64_t bytes, std::uint32_t failed);
  /// Returns the worker that source_for() named last. 0: the coordinator.
  [[nodiscard]] WorkerId source_of(WorkerId worker, const std::string& scene) const;

  /// Returns a chunk of the scene whose bytes are `bytes`; nothing if `index` is too large. Caches
  /// the last few packed chunks.
  std::optional<msg::Chunk> chunk(const std::string& scene, const Frame& bytes,
                                  std::uint32_t index);

  /// Removes a worker that left or is in quarantine: it serves no other worker any more.
  void forget_worker(WorkerId id);
  /// How far a scene has spread.
  struct Spread {
    std::size_t workers = 0;  ///< workers that requested it
    std::uint64_t bytes = 0;  ///< bytes that the coordinator sent
  };
  /// Removes a scene that no job needs any more.
  Spread forget_scene(const std::string& scene);

 private:
  /// A worker in the tree of one scene.
  struct Node {
    WorkerId id = 0;
    std::string machine;
    std::string address;  ///< empty: it does not serve others
    std::string key;
    bool loopback = false;            ///< its address is valid only on the coordinator's machine
    bool placed = false;              ///< has a source
    WorkerId source = 0;              ///< 0: the coordinator
    bool remote = false;              ///< its source is on another machine
    std::uint32_t served_remote = 0;  ///< workers of other machines that it serves
    std::uint32_t served_local = 0;   ///< workers of its machine that it serves
    std::uint32_t failed = 0;         ///< sources that failed, by the worker's count
    std::set<WorkerId> refused{};     ///< sources that failed for it
  };
  struct Tree {
    std::vector<Node> nodes;   ///< in the order of their first requests
    std::uint32_t served = 0;  ///< machines that the coordinator serves
    std::uint64_t bytes = 0;
  };

  static Node node_of(const WorkerRecord& worker);
  static Node* find(Tree& tree, WorkerId id);
  static void release(Tree& tree, Node& node);
  void place(Tree& tree, Node& node);
  [[nodiscard]] bool may_serve(const Node& source, const Node& node) const;

  const std::uint32_t chunk_bytes_;
  std::map<std::string, Tree> trees_;             ///< by scene
  std::map<WorkerId, std::uint32_t> complaints_;  ///< workers for which this source failed
  std::deque<msg::Chunk> chunks_;                 ///< the last few packed chunks
};

}  // namespace parray::coordinator
