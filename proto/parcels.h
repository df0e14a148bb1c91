#pragma once

#include <cstdint>
#include <memory>
#include <stdexcept>
#include <string>
#include <string_view>
#include <utility>
#include <variant>

#include "common/image/picture_bytes.h"
#include "common/scene/scene.h"
#include "common/schedule/traced_cells.h"
#include "proto/frame.h"

/// The large parts of messages. Between processes they are bytes; inside one process they are the
/// things themselves, and nothing is encoded at all. Copies share; any thread.
namespace parray::proto {

/// The bulk frame of a message, as it came. Whether its checksum is right is looked at by whoever
/// opens it, because that takes time.
struct Bulk {
  Frame data;
  std::uint64_t checksum = 0;

  /// Throws ChecksumError when the checksum is wrong.
  [[nodiscard]] std::string_view verified() const;
  /// Of bytes of our own.
  static Bulk of(std::string bytes);
  static Bulk of(Frame bytes);
};

class SceneParcel {
 public:
  SceneParcel() = default;
  explicit SceneParcel(std::shared_ptr<const Scene> scene) : content_(std::move(scene)) {}
  explicit SceneParcel(Bulk bytes) : content_(std::move(bytes)) {}

  /// Decodes where need be. Throws DecodeError.
  [[nodiscard]] std::shared_ptr<const Scene> scene() const;
  /// scene_to_bytes(). Throws DecodeError when the checksum is wrong.
  [[nodiscard]] Bulk bytes() const;
  /// scene_identity(). Throws DecodeError when the checksum is wrong.
  [[nodiscard]] std::string identity() const;
  /// Bytes that it takes in memory, roughly.
  [[nodiscard]] std::uint64_t size() const;
  /// The bytes that it holds, unchecked; null where it holds the scene itself.
  [[nodiscard]] const Bulk* held_bytes() const { return std::get_if<Bulk>(&content_); }

 private:
  std::variant<std::shared_ptr<const Scene>, Bulk> content_;
};

class CellsParcel {
 public:
  CellsParcel() = default;
  explicit CellsParcel(std::shared_ptr<const TracedCells> cells) : content_(std::move(cells)) {}
  explicit CellsParcel(Bulk packed) : content_(std::move(packed)) {}

  /// What a worker has made of `batch`. Throws DecodeError when it is something else, or holds
  /// impossible numbers: see unpack_cells().
  [[nodiscard]] std::shared_ptr<const TracedCells> open(const CellBatch& batch,
                                                        std::uint32_t max_depth) const;
  /// pack_cells(); `grid` is the batch's. Throws DecodeError when the checksum is wrong.
  [[nodiscard]] Bulk packed(const CellGrid& grid) const;
  [[nodiscard]] std::uint64_t size() const;

 private:
  std::variant<std::shared_ptr<const TracedCells>, Bulk> content_;
};

/// A finished picture, or what there is of one.
class PictureParcel {
 public:
  PictureParcel() = default;
  explicit PictureParcel(std::shared_ptr<const PictureParts> picture)
      : content_(std::move(picture)) {}
  explicit PictureParcel(Bulk bytes) : content_(std::move(bytes)) {}

  /// Throws DecodeError when it is no picture of this size.
  [[nodiscard]] std::shared_ptr<const PictureParts> picture(std::uint32_t width,
                                                            std::uint32_t height) const;
  /// Throws ChecksumError when bytes have come that were changed on their way.
  void verify() const;
  /// picture_to_bytes() of what is wanted and there. Throws ChecksumError.
  [[nodiscard]] Bulk bytes(PictureDetail detail) const;

 private:
  std::variant<std::shared_ptr<const PictureParts>, Bulk> content_;
};

}  // namespace parray::proto
