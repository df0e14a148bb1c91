#include "coordinator/loop/scene_service.h"

#include <algorithm>
#include <utility>

namespace parray::coordinator {
namespace {

/// Chunks kept as they travel: workers that are served at once ask for the same ones.
constexpr std::size_t chunks_kept = 64;
/// Sources that a worker tries before it is served by the coordinator.
constexpr std::uint32_t most_tries = 3;
/// So many workers that could not use a source have the others spared it.
constexpr std::uint32_t most_complaints = 2;

std::string endpoint(const std::string& address, std::uint32_t port) {
  const bool v6 = address.find(':') != std::string::npos;
  return "tcp://" + (v6 ? '[' + address + ']' : address) + ':' + std::to_string(port);
}

}  // namespace

/// Workers of one host name are of one machine if they are seen by one address.
SceneService::Node SceneService::node_of(const WorkerRecord& worker) {
  Node node;
  node.id = worker.id;
  node.machine = worker.hello.host.empty() ? '#' + std::to_string(worker.id)
                                           : worker.hello.host + ' ' + worker.address;
  node.loopback = worker.address.starts_with("127.") || worker.address == "::1" ||
                  worker.address == "localhost";
  if (worker.hello.share_port != 0 && !worker.address.empty()) {
    node.address = endpoint(worker.address, worker.hello.share_port);
    node.key = worker.hello.share_key;
  }
  return node;
}

SceneService::Node* SceneService::find(Tree& tree, WorkerId id) {
  const auto found = std::find_if(tree.nodes.begin(), tree.nodes.end(),
                                  [id](const Node& node) { return node.id == id; });
  return found == tree.nodes.end() ? nullptr : &*found;
}

msg::SceneSource SceneService::source_for(const WorkerRecord& worker, const std::string& scene,
                                          std::uint64_t bytes, std::uint32_t failed) {
  Tree& tree = trees_[scene];
  Node* node = find(tree, worker.id);
  if (node == nullptr) {
    node = &tree.nodes.emplace_back(node_of(worker));
  }
  if (failed > node->failed) {
    if (node->source != 0) {
      node->refused.insert(node->source);
      ++useless_[node->source];
    }
    node->failed = failed;
    release(tree, *node);
  }
  if (!node->placed) {
    place(tree, *node);
  }
  msg::SceneSource answer{scene, {bytes, chunk_bytes_}};
  if (const Node* source = find(tree, node->source)) {
    answer.address = source->address;
    answer.key = source->key;
  }
  return answer;
}

WorkerId SceneService::source_of(WorkerId worker, const std::string& scene) const {
  const auto tree = trees_.find(scene);
  if (tree != trees_.end()) {
    for (const Node& node : tree->second.nodes) {
      if (node.id == worker) {
        return node.source;
      }
    }
  }
  return 0;
}

bool SceneService::may_serve(const Node& source, const Node& node) const {
  const auto complaints = useless_.find(source.id);
  return source.placed && !source.address.empty() && (!source.loopback || node.loopback) &&
         !node.refused.contains(source.id) &&
         (complaints == useless_.end() || complaints->second < most_complaints);
}

/// Among those before it: one of its machine, else the coordinator, else one that gets the scene
/// from another machine, too. Who came first is nearest to the coordinator.
void SceneService::place(Tree& tree, Node& node) {
  node.placed = true;
  const auto end = tree.nodes.begin() + (&node - tree.nodes.data());
  const auto serve_by = [&](auto fits) {
    const auto found = node.address.empty() || node.failed >= most_tries
                           ? end
                           : std::find_if(tree.nodes.begin(), end, fits);
    node.source = found == end ? 0 : found->id;
    return found == end ? nullptr : &*found;
  };
  if (Node* here = serve_by([&](const Node& source) {
        return source.machine == node.machine && source.served_here < fan_out &&
               may_serve(source, node);
      })) {
    node.abroad = false;
    ++here->served_here;
    return;
  }
  node.abroad = true;
  if (tree.served < fan_out) {
    ++tree.served;
    return;
  }
  if (Node* there = serve_by([&](const Node& source) {
        return source.abroad && source.served_abroad < fan_out && may_serve(source, node);
      })) {
    ++there->served_abroad;
    return;
  }
  ++tree.served;
}

/// Takes its source from a worker.
void SceneService::release(Tree& tree, Node& node) {
  if (!node.placed) {
    return;
  }
  if (Node* source = find(tree, node.source)) {
    --(node.abroad ? source->served_abroad : source->served_here);
  } else if (node.source == 0) {
    --tree.served;
  }
  node.placed = false;
  node.source = 0;
}

std::optional<msg::Chunk> SceneService::chunk(const std::string& scene, const Frame& bytes,
                                              std::uint32_t index) {
  const ChunkCut cut{bytes.size(), chunk_bytes_};
  if (index >= cut.count()) {
    return {};
  }
  auto known = std::find_if(chunks_.begin(), chunks_.end(), [&](const msg::Chunk& chunk) {
    return chunk.chunk == index && chunk.scene == scene;
  });
  if (known == chunks_.end()) {
    const std::string_view plain = bytes.view().substr(cut.begin(index), cut.size(index));
    std::string packed = pack_chunk(plain);
    const bool smaller = !packed.empty();
    chunks_.push_back({scene, index, smaller,
                       Bulk::of(smaller ? Frame(std::move(packed)) : Frame(bytes.owner(), plain))});
    if (chunks_.size() > chunks_kept) {
      chunks_.pop_front();
    }
    known = chunks_.end() - 1;
  }
  trees_[scene].bytes += known->content.data.size();
  return *known;
}

void SceneService::forget_worker(WorkerId id) {
  useless_.erase(id);
  for (auto& [scene, tree] : trees_) {
    Node* const node = find(tree, id);
    if (node == nullptr) {
      continue;
    }
    release(tree, *node);
    tree.nodes.erase(tree.nodes.begin() + (node - tree.nodes.data()));
    for (Node& other : tree.nodes) {
      if (other.placed && other.source == id) {
        other.placed = false;  // it will say so
        other.source = 0;
      }
    }
  }
}

SceneService::Spread SceneService::forget_scene(const std::string& scene) {
  std::erase_if(chunks_, [&](const msg::Chunk& chunk) { return chunk.scene == scene; });
  const auto tree = trees_.extract(scene);
  return tree ? Spread{tree.mapped().nodes.size(), tree.mapped().bytes} : Spread{};
}

}  // namespace parray::coordinator
