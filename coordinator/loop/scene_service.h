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

/// Who gets a scene from whom, so that it leaves the coordinator but a few times however many
/// workers there are, and crosses the network once for each machine. Workers of a scene make a tree
/// in the order in which they have asked: nobody gets it from one that came later, so there is no
/// circle whatever happens. Plain state; one thread.
class SceneService {
 public:
  /// Machines that the coordinator serves, and that each machine serves; workers of one machine
  /// that one of them serves.
  static constexpr std::uint32_t fan_out = 2;

  explicit SceneService(std::uint32_t chunk_bytes = usual_chunk_bytes)
      : chunk_bytes_(chunk_bytes) {}

  /// Where `worker` is to get `scene` from. `failed`: see `need_scene`; a higher number than last
  /// time says that the source of last time was of no use.
  msg::SceneSource source_for(const WorkerRecord& worker, const std::string& scene,
                              std::uint64_t bytes, std::uint32_t failed);
  /// The worker that source_for() has named last; 0: the coordinator itself.
  [[nodiscard]] WorkerId source_of(WorkerId worker, const std::string& scene) const;

  /// A chunk of the scene whose bytes these are; none if it has no such chunk. The last few are
  /// kept as they travel.
  std::optional<msg::Chunk> chunk(const std::string& scene, const Frame& bytes,
                                  std::uint32_t index);

  /// The worker has left, or is not to be trusted: it serves nobody any more.
  void forget_worker(WorkerId id);
  /// What has been sent of a scene that no job needs any more.
  struct Spread {
    std::size_t workers = 0;
    std::uint64_t bytes = 0;  ///< sent by the coordinator
  };
  Spread forget_scene(const std::string& scene);

 private:
  /// A worker, where one scene is concerned.
  struct Node {
    WorkerId id = 0;
    std::string machine;
    std::string address;  ///< empty: it serves nobody
    std::string key;
    bool loopback = false;  ///< seen by an address that only the coordinator's machine has
    bool placed = false;    ///< has a source
    WorkerId source = 0;
    bool abroad = false;  ///< its source is another machine
    std::uint32_t served_abroad = 0;
    std::uint32_t served_here = 0;
    std::uint32_t failed = 0;
    std::set<WorkerId> refused{};  ///< sources that were of no use to it
  };
  struct Tree {
    std::vector<Node> nodes;   ///< in the order in which they have come
    std::uint32_t served = 0;  ///< machines, by the coordinator
    std::uint64_t bytes = 0;
  };

  static Node node_of(const WorkerRecord& worker);
  static Node* find(Tree& tree, WorkerId id);
  static void release(Tree& tree, Node& node);
  void place(Tree& tree, Node& node);
  [[nodiscard]] bool may_serve(const Node& source, const Node& node) const;

  const std::uint32_t chunk_bytes_;
  std::map<std::string, Tree> trees_;          ///< by scene
  std::map<WorkerId, std::uint32_t> useless_;  ///< how many have said so
  std::deque<msg::Chunk> chunks_;              ///< the last few
};

}  // namespace parray::coordinator
