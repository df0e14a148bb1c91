#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <string_view>
#include <utility>
#include <variant>

#include "common/image/picture_bytes.h"
#include "common/scene/scene.h"
#include "common/schedule/traced_cells.h"
#include "proto/frame.h"

/// The large parts of messages. Between processes they are bytes. Inside one process they are the
/// objects themselves, and nothing is encoded. Copies share their content. Thread-safe.
namespace parray::proto {

/// The bulk frame (large second frame) of a message. The checksum takes time: decode() compares it
/// only for a `grant`, and users of other messages call verified().
struct Bulk {
  Frame data;
  std::uint64_t checksum = 0;  ///< XXH3-64 of the data

  /// Returns the bytes. Throws ChecksumError if the checksum is wrong.
  [[nodiscard]] std::string_view verified() const;
  /// Make a bulk frame with its checksum from bytes of this process.
  static Bulk of(std::string bytes);
  static Bulk of(Frame bytes);
};

class ScenePayload {
 public:
  ScenePayload() = default;
  explicit ScenePayload(std::shared_ptr<const Scene> scene) : content_(std::move(scene)) {}
  explicit ScenePayload(Bulk bytes) : content_(std::move(bytes)) {}

  /// Returns the scene; decodes it if necessary. Throws DecodeError.
  [[nodiscard]] std::shared_ptr<const Scene> scene() const;
  /// Returns the bytes of scene_to_bytes(). Throws DecodeError if the checksum is wrong.
  [[nodiscard]] Bulk bytes() const;
  /// Returns scene_identity(), the SHA-256 of bytes(). Throws DecodeError if the checksum is wrong.
  [[nodiscard]] std::string identity() const;
  /// Returns the approximate number of bytes in memory; 0 if the payload holds nothing.
  [[nodiscard]] std::uint64_t size() const;
  /// Returns the stored bytes, unchecked; null if the payload holds the scene itself.
  [[nodiscard]] const Bulk* held_bytes() const { return std::get_if<Bulk>(&content_); }

 private:
  std::variant<std::shared_ptr<const Scene>, Bulk> content_;
};

class CellsPayload {
 public:
  CellsPayload() = default;
  explicit CellsPayload(std::shared_ptr<const TracedCells> cells) : content_(std::move(cells)) {}
  explicit CellsPayload(Bulk packed) : content_(std::move(packed)) {}

  /// Returns a worker's result for `batch`. Throws DecodeError if the content is something else, or
  /// has impossible numbers: see unpack_cells().
  [[nodiscard]] std::shared_ptr<const TracedCells> open(const CellBatch& batch,
                                                        std::uint32_t max_depth) const;
  /// Returns the bytes of pack_cells(); `grid` is the batch's grid. Throws DecodeError if the
  /// checksum is wrong.
  [[nodiscard]] Bulk packed(const CellGrid& grid) const;
  /// Returns the approximate number of bytes in memory.
  [[nodiscard]] std::uint64_t size() const;

 private:
  std::variant<std::shared_ptr<const TracedCells>, Bulk> content_;
};

/// A finished picture, or the present state of one.
class PicturePayload {
 public:
  PicturePayload() = default;
  explicit PicturePayload(std::shared_ptr<const PictureParts> picture)
      : content_(std::move(picture)) {}
  explicit PicturePayload(Bulk bytes) : content_(std::move(bytes)) {}

  /// Returns the picture. Throws DecodeError if received bytes are not a picture of this size.
  [[nodiscard]] std::shared_ptr<const PictureParts> picture(std::uint32_t width,
                                                            std::uint32_t height) const;
  /// Throws ChecksumError if received bytes were changed on their way.
  void verify() const;
  /// Returns the bytes of picture_to_bytes(), with the wanted detail as far as the picture has it.
  /// Returns received bytes as they are, whatever `detail` says. Throws ChecksumError.
  [[nodiscard]] Bulk bytes(PictureDetail detail) const;

 private:
  std::variant<std::shared_ptr<const PictureParts>, Bulk> content_;
};

}  // namespace parray::proto
