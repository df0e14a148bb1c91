#include <spdlog/spdlog.h>

#include "coordinator/loop/farm.h"
#include "coordinator/loop/worker_desk.h"

namespace parray::coordinator {

/// Finds a scene by its SHA-256 among the jobs at work. Null: no job at work has it.
const ScenePayload* WorkerDesk::scene_at_work(const std::string& scene) const {
  for (const JobId id : farm_.at_work) {
    const Job& job = farm_.jobs.at(id);
    if (job.work && job.record.scene == scene && job.work->plan) return &job.work->scene;
  }
  return nullptr;
}

void WorkerDesk::on(Time now, const PeerId& peer, msg::NeedScene& m) {
  WorkerRecord* worker = heard_from(now, peer);
  if (worker == nullptr) return;
  const ScenePayload* scene = scene_at_work(m.scene);
  if (scene == nullptr) return;
  const Bulk* bytes = scene->held_bytes();
  if (bytes == nullptr) {  // the worker is in this process
    farm_.send(peer, msg::SceneSource{m.scene, {}, "", "", scene->scene()});
    return;
  }
  farm_.send(peer, farm_.scenes.source_for(*worker, m.scene, bytes->data.size(), m.failed));
  const WorkerRecord* source = farm_.workers.by_id(farm_.scenes.source_of(worker->id, m.scene));
  farm_.log->debug("scene {:.8} for worker {} '{}': from {}{}", m.scene, worker->id,
                   worker->hello.name, source == nullptr ? "the coordinator" : source->hello.name,
                   m.failed > 0 ? fmt::format(", attempt {}", m.failed + 1) : "");
}

void WorkerDesk::on(Time now, const PeerId& peer, msg::NeedChunk& m) {
  WorkerRecord* worker = heard_from(now, peer);
  if (worker == nullptr) return;
  const ScenePayload* scene = scene_at_work(m.scene);
  const Bulk* bytes = scene == nullptr ? nullptr : scene->held_bytes();
  auto chunk = bytes == nullptr ? std::nullopt : farm_.scenes.chunk(m.scene, bytes->data, m.chunk);
  if (chunk) {
    farm_.send(peer, std::move(*chunk));
  } else {
    farm_.send(peer, msg::NoScene{m.scene});
  }
}

void WorkerDesk::forget_scene(const std::string& scene) {
  if (scene_at_work(scene) != nullptr) return;
  const SceneService::Spread spread = farm_.scenes.forget_scene(scene);
  if (spread.workers > 0) {
    farm_.log->debug("{1} workers requested scene {0:.8}; the coordinator sent {2} bytes", scene,
                     spread.workers, spread.bytes);
  }
}

}  // namespace parray::coordinator
