#include "proto/payloads.h"

#include <algorithm>

#include "common/base/bytes.h"
#include "common/base/checksum.h"
#include "common/scene/scene_bytes.h"

namespace parray::proto {
namespace {

std::uint64_t bytes_in_memory(const Scene& scene) {
  return sizeof(Scene) + scene.materials.size() * sizeof(Material) +
         scene.spheres.size() * sizeof(Sphere) + scene.capsules.size() * sizeof(Capsule);
}

}  // namespace

std::string_view Bulk::verified() const {
  if (checksum_of(data.view()) != checksum) {
    throw ChecksumError("bulk frame has a wrong checksum");
  }
  return data.view();
}

Bulk Bulk::of(std::string bytes) { return of(Frame(std::move(bytes))); }

Bulk Bulk::of(Frame bytes) {
  const std::uint64_t checksum = checksum_of(bytes.view());
  return {std::move(bytes), checksum};
}

std::shared_ptr<const Scene> ScenePayload::scene() const {
  if (const auto* scene = std::get_if<0>(&content_)) return *scene;
  return std::make_shared<const Scene>(scene_from_bytes(std::get<Bulk>(content_).verified()));
}

Bulk ScenePayload::bytes() const {
  if (const auto* scene = std::get_if<0>(&content_)) return Bulk::of(scene_to_bytes(**scene));
  (void)std::get<Bulk>(content_).verified();
  return std::get<Bulk>(content_);
}

std::string ScenePayload::identity() const {
  if (const auto* scene = std::get_if<0>(&content_)) return scene_identity(**scene);
  return scene_identity(std::get<Bulk>(content_).verified());
}

std::uint64_t ScenePayload::size() const {
  if (const auto* held = std::get_if<0>(&content_)) return *held ? bytes_in_memory(**held) : 0;
  return std::get<Bulk>(content_).data.size();
}

std::shared_ptr<const TracedCells> CellsPayload::open(const CellBatch& batch,
                                                      std::uint32_t max_depth) const {
  if (const auto* bulk = std::get_if<Bulk>(&content_)) {
    return std::make_shared<const TracedCells>(unpack_cells(bulk->verified(), batch, max_depth));
  }
  const auto& cells = std::get<0>(content_);
  if (const std::string fault = fault_of(*cells, batch, max_depth); !fault.empty()) {
    throw DecodeError(fault);
  }
  return cells;
}

Bulk CellsPayload::packed(const CellGrid& grid) const {
  if (const auto* cells = std::get_if<0>(&content_)) return Bulk::of(pack_cells(**cells, grid));
  (void)std::get<Bulk>(content_).verified();
  return std::get<Bulk>(content_);
}

std::uint64_t CellsPayload::size() const {
  if (const auto* cells = std::get_if<0>(&content_)) return *cells ? (*cells)->records.size() : 0;
  return std::get<Bulk>(content_).data.size();
}

std::shared_ptr<const PictureParts> PicturePayload::picture(std::uint32_t width,
                                                            std::uint32_t height) const {
  if (const auto* picture = std::get_if<0>(&content_)) return *picture;
  return std::make_shared<const PictureParts>(
      picture_from_bytes(width, height, std::get<Bulk>(content_).verified()));
}

void PicturePayload::verify() const {
  if (const auto* bulk = std::get_if<Bulk>(&content_)) (void)bulk->verified();
}

Bulk PicturePayload::bytes(PictureDetail detail) const {
  if (const auto* picture = std::get_if<0>(&content_)) {
    const PictureParts& parts = **picture;
    std::string bytes = picture_to_bytes(
        parts.image, detail == PictureDetail::image ? PictureStatistics{} : parts.statistics);
    bytes.resize(std::min<std::size_t>(
        bytes.size(), picture_size(parts.image.width, parts.image.height, detail)));
    return Bulk::of(std::move(bytes));
  }
  (void)std::get<Bulk>(content_).verified();
  return std::get<Bulk>(content_);
}

}  // namespace parray::proto
