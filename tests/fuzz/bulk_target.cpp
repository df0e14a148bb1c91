#include <algorithm>

#include "common/base/bytes.h"
#include "common/image/picture_bytes.h"
#include "common/scene/scene_bytes.h"
#include "common/schedule/traced_cells.h"
#include "proto/payloads.h"
#include "tests/fuzz/target.h"
#include "tests/support/rooms.h"
#include "tests/support/sample_messages.h"
#include "tests/support/sample_scenes.h"
#include "tests/support/window_rig.h"

namespace parray::fuzz {
namespace {

// Kinds of bulk, by an input's first letter.
constexpr char scene = 's';
constexpr char one_cell = 'c';    // whose pixels have ranges of their own
constexpr char some_cells = 'C';  // two layers of samples, cells of different length
constexpr char picture = 'p';     // width and height less 1 (u8 each), then the picture

constexpr std::uint32_t max_depth = 50;

CellBatch some_batch() {
  const GridShape shape{20, 6, RowOrder::interleaved, 4, 15, 8, 2, {{0, 12}}};
  return {std::make_shared<const CellGrid>(shape), {3, 20}, {}};
}

bool run_scene(std::string_view bytes) {
  const auto decoded = ScenePayload(Bulk::of(std::string(bytes))).scene();
  promise(scene_to_bytes(*decoded) == bytes, "equal scenes have equal bytes");
  promise_usable(*decoded, {});
  return true;
}

/// Excluded samples are ones that their pixel has, each named once.
void promise_excluded(const TracedCells& cells, const CellBatch& batch) {
  promise(std::ranges::is_sorted(cells.excluded), "excluded samples in order");
  for (std::size_t i = 0; i < cells.excluded.size(); ++i) {
    const ExcludedSamples& some = cells.excluded[i];
    std::uint64_t has = 0;
    for (std::uint64_t index = batch.range.begin; index < batch.range.end; ++index) {
      const Cell cell = batch.grid->cell(index);
      if (cell.y != some.y || some.x < cell.x_begin || some.x >= cell.x_end) continue;
      const SampleRange own = batch.run_samples(index)[some.x - cell.x_begin];
      if (some.first >= own.begin && some.first < own.end) has = own.end - some.first;
    }
    promise(some.count >= 1 && some.count <= has, "excluded samples that the pixel has");
    const bool again = i > 0 && cells.excluded[i - 1].y == some.y &&
                       cells.excluded[i - 1].x == some.x &&
                       cells.excluded[i - 1].first == some.first;
    promise(!again, "one entry a pixel and cell");
  }
}

bool run_cells(std::string_view bytes, const CellBatch& batch) {
  const auto cells = CellsPayload(Bulk::of(std::string(bytes))).open(batch, max_depth);
  promise(pack_cells(*cells, *batch.grid) == bytes, "equal cells have equal bytes");
  promise(fault_of(*cells, batch, max_depth).empty(), "one rule for cells of both ways");
  promise_excluded(*cells, batch);
  return true;
}

bool run_picture(std::string_view bytes) {
  ByteReader in(bytes);
  const std::uint32_t width = 1U + in.get<std::uint8_t>();
  const std::uint32_t height = 1U + in.get<std::uint8_t>();
  const std::string rest(in.get_bytes(in.left()));
  const auto parts = PicturePayload(Bulk::of(rest)).picture(width, height);
  promise(picture_to_bytes(parts->image, parts->statistics) == rest, "a picture as packed");
  return true;
}

bool run(std::string_view input) {
  try {
    switch (take_letter(input)) {
      case scene: return run_scene(input);
      case one_cell: return run_cells(input, test::sample_batch());
      case picture: return run_picture(input);
      default: return run_cells(input, some_batch());
    }
  } catch (const DecodeError& error) {
    promise_one_line(error.what());
    return false;
  }
}

std::vector<std::string> seeds() {
  Scene bare;
  bare.camera.tan_half_vfov = 0.25;
  const CellBatch batch = some_batch();
  TracedCells finite = test::made_cells(batch);
  return {scene + scene_to_bytes(test::small_scene()),
          scene + scene_to_bytes(bare),
          one_cell + pack_cells(test::sample_cells(), *test::sample_batch().grid),
          one_cell + pack_cells(test::made_cells(test::sample_batch()), *test::sample_batch().grid),
          some_cells + pack_cells(test::made_cells(batch), *batch.grid),
          std::string{picture, 1, 2} + std::string(72, '\x3f'),
          std::string{picture, 1, 2} + std::string(168, '\x3f')};
}

}  // namespace

const Target bulk_target{"bulk", run, seeds};

}  // namespace parray::fuzz
