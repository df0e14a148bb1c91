#include "worker/scene_opener.h"

#include <algorithm>
#include <exception>
#include <span>
#include <utility>

#include "common/base/bytes.h"
#include "common/scene/scene_bytes.h"

namespace parray::worker {
namespace {

std::string bytes_of(const ScenePieces& packed) {
  std::string bytes(packed.cut.bytes, '\0');
  for (std::uint32_t i = 0; i < packed.cut.count(); ++i) {
    const std::span<char> chunk = std::span(bytes).subspan(packed.cut.begin(i), packed.cut.size(i));
    const std::string_view piece = packed.pieces[i].content.data.view();
    if (packed.pieces[i].packed) {
      unpack_chunk(piece, chunk);
    } else {
      std::copy(piece.begin(), piece.end(), chunk.begin());
    }
  }
  return bytes;
}

/// Decodes the scene. If the bytes have the right identity but this program cannot read them,
/// another source would not help: it reports a failure.
void read(const std::string& bytes, OpenedScene& opened) {
  try {
    opened.scene = std::make_shared<const Scene>(scene_from_bytes(bytes));
  } catch (const DecodeError& error) {
    opened.failure = error.what();
  }
}

}  // namespace

OpenedScene open_scene(const ScenePieces& packed) {
  OpenedScene opened{packed.id, nullptr};
  try {
    const std::string bytes = bytes_of(packed);
    if (scene_identity(bytes) == packed.id) read(bytes, opened);
  } catch (const DecodeError&) {
    // A chunk was replaced by other content.
  } catch (const std::bad_alloc&) {
    opened.failure = "not enough memory for the scene";
  } catch (const std::exception& error) {
    opened.failure = std::string("opening the scene: ") + error.what();
  }
  return opened;
}

SceneOpener::SceneOpener(const std::function<void()>& wake) {
  if (wake) {
    thread_ = std::make_unique<TaskThread<ScenePieces, OpenedScene>>(
        [](const ScenePieces& packed, const std::atomic<bool>& /*stop*/) {
          return open_scene(packed);
        },
        wake);
  }
}

void SceneOpener::start(ScenePieces packed) {
  if (thread_) {
    thread_->start(std::move(packed));
  } else {
    opened_ = open_scene(packed);
  }
}

std::optional<OpenedScene> SceneOpener::take() {
  return thread_ ? thread_->take() : std::exchange(opened_, std::nullopt);
}

}  // namespace parray::worker
