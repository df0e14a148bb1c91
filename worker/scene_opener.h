#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "common/scene/scene.h"
#include "common/scene/scene_chunks.h"
#include "proto/payloads.h"
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

/// Opens a scene from its chunks. All of them must have arrived. Never throws.
OpenedScene open_scene(const ScenePieces& packed);

/// Opens scenes on a background thread, because large scenes take seconds.
class SceneOpener {
 public:
  /// The background thread calls `wake` when take() has a scene. Without `wake`, start() opens the
  /// scene in the calling thread.
  explicit SceneOpener(const std::function<void()>& wake);

  /// Begins to open a scene, as open_scene() does. Call it only when idle.
  void start(ScenePieces packed);
  [[nodiscard]] bool idle() const { return thread_ ? thread_->idle() : !opened_; }
  /// Returns the opened scene, once.
  std::optional<OpenedScene> take();

 private:
  std::optional<OpenedScene> opened_;  ///< scene opened without a background thread
  std::unique_ptr<TaskThread<ScenePieces, OpenedScene>> thread_;
};

}  // namespace parray::worker
