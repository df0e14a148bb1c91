#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "common/scene/scene.h"
#include "common/scene/scene_chunks.h"
#include "proto/parcels.h"
#include "worker/task_thread.h"

namespace parray::worker {

/// A chunk as it has come.
struct ScenePiece {
  bool packed = false;
  Bulk content{};  ///< empty: it has not come

  [[nodiscard]] bool here() const { return content.data.size() > 0; }
};

/// All of a scene, as it has come.
struct ScenePieces {
  std::string id;  ///< scene_identity()
  ChunkCut cut;
  std::vector<ScenePiece> pieces;
};

struct OpenedScene {
  std::string id;
  std::shared_ptr<const Scene> scene;  ///< null: the pieces are not those of `id`
  std::string failure{};               ///< why they could not be opened at all
};

/// Never throws.
OpenedScene open_scene(const ScenePieces& packed);

/// Opens scenes, which takes seconds where they are large, beside the thread that owns it.
class SceneOpener {
 public:
  /// `wake`: called from another thread when a scene is open; without it, scenes are opened at
  /// once.
  explicit SceneOpener(const std::function<void()>& wake);

  /// Only when idle.
  void start(ScenePieces packed);
  [[nodiscard]] bool idle() const;
  /// The scene, once.
  std::optional<OpenedScene> take();

 private:
  std::optional<OpenedScene> opened_;  ///< at once
  std::unique_ptr<TaskThread<ScenePieces, OpenedScene>> thread_;
};

}  // namespace parray::worker
