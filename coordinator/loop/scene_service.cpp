#include "coordinator/loop/scene_service.h"

#include <algorithm>
#include <utility>

namespace parray::coordinator {
namespace {

/// Packed chunks in the cache: workers that load a scene at the same time need the same chunks.
constexpr std::size_t chunks_kept = 64;
/// Sources that may fail for a worker before the coordinator serves it.
constexpr std::uint32_t most_tries = 3;
/// Workers for which a source may fail before it serves no others.
constexpr std::uint32_t most_complaints = 2;

std::string endpoint(const std::string& address, std::uint32_t port) {
  const bool v6 = address.find(':') != std::string::npos;
  return "tcp://" + (v6 ? '[' + address + ']' : address) + ':' + std::to_string(port);
}

}  // namespace

/// Workers with the same host name and the same address are on one machine.
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
  const auto found =
      std::ranges::find_if(tree.nodes, [id](const Node& node) { return node.id == id; });
  return found == tree.nodes.end() ? nullptr : &*found;
}

msg::SceneSource SceneService::source_for(const WorkerRecord& worker, const std::string& scene,
                                          std::uint64_t bytes, std::uint32_t failed) {
  Tree& tree = trees_[scene];
  Node* node = find(tree, worker.id);
  if (node == nullptr) node = &tree.nodes.emplace_back(node_of(worker));
  if (failed > node->failed) {
    if (node->source != 0) {
      node->refused.insert(node->source);
      ++complaints_[node->source];
    }
    node->failed = failed;
    release(tree, *node);
  }
  if (!node->placed) place(tree, *node);
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
      if (node.id == worker) return node.source;
    }
  }
  return 0;
}

bool SceneService::may_serve(const Node& source, const Node& node) const {
  const auto complaints = complaints_.find(source.id);
  return source.placed && !source.address.empty() && (!source.loopback || node.loopback) &&
         !node.refused.contains(source.id) &&
         (complaints == complaints_.end() || complaints->second < most_complaints);
}

/// Selects the first earlier worker on the same machine, else the coordinator, else the first
/// earlier worker whose own source is remote. The earliest is nearest to the coordinator.
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
  if (Node* local = serve_by([&](const Node& source) {
        return source.machine == node.machine && source.served_local < fan_out &&
               may_serve(source, node);
      })) {
    node.remote = false;
    ++local->served_local;
    return;
  }
  node.remote = true;
  if (tree.served < fan_out) {
    ++tree.served;
    return;
  }
  if (Node* remote_source = serve_by([&](const Node& source) {
        return source.remote && source.served_remote < fan_out && may_serve(source, node);
      })) {
    ++remote_source->served_remote;
    return;
  }
  ++tree.served;
}

/// Separates a node from its source.
void SceneService::release(Tree& tree, Node& node) {
  if (!node.placed) return;
  if (Node* source = find(tree, node.source)) {
    --(node.remote ? source->served_remote : source->served_local);
  } else if (node.source == 0) {
    --tree.served;
  }
  node.placed = false;
  node.source = 0;
}

std::optional<msg::Chunk> SceneService::chunk(const std::string& scene, const Frame& bytes,
                                              std::uint32_t index) {
  const ChunkCut cut{bytes.size(), chunk_bytes_};
  if (index >= cut.count()) return {};
  auto known = std::ranges::find_if(chunks_, [&](const msg::Chunk& chunk) {
    return chunk.chunk == index && chunk.scene == scene;
  });
  if (known == chunks_.end()) {
    const std::string_view plain = bytes.view().substr(cut.begin(index), cut.size(index));
    std::string packed = pack_chunk(plain);
    const bool smaller = !packed.empty();
    chunks_.push_back({scene, index, smaller,
                       Bulk::of(smaller ? Frame(std::move(packed)) : Frame(bytes.owner(), plain))});
    if (chunks_.size() > chunks_kept) chunks_.pop_front();
    known = chunks_.end() - 1;
  }
  trees_[scene].bytes += known->content.data.size();
  return *known;
}

void SceneService::forget_worker(WorkerId id) {
  complaints_.erase(id);
  for (auto& [scene, tree] : trees_) {
    Node* const node = find(tree, id);
    if (node == nullptr) continue;
    release(tree, *node);
    tree.nodes.erase(tree.nodes.begin() + (node - tree.nodes.data()));
    for (Node& other : tree.nodes) {
      if (other.placed && other.source == id) {
        other.placed = false;  // it will report the failed source
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
