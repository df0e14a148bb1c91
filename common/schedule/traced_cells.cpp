#include "common/schedule/traced_cells.h"

#include <algorithm>
#include <array>
#include <cstring>
#include <map>
#include <optional>
#include <utility>

#include "common/base/bytes.h"
#include "common/image/packed_sums.h"
#include "common/image/radiance_scale.h"

namespace parray::schedule {
namespace {

constexpr std::uint64_t one = std::uint64_t{1} << 32;  // RadianceScale::one
/// Fewest bytes of a packed cell: three counts, and the sums in their shortest form, in which all
/// pixels have equal sums and columns that follow from others are left out.
constexpr std::size_t least_cell_bytes = 3 * sizeof(std::uint64_t) + 4;

bool within_bounds(const PixelSums& sums, std::uint64_t samples) {
  for (std::size_t channel = 0; channel < 3; ++channel) {
    if (sums.sum[channel] > samples * one || sums.sum_of_squares[channel] > samples * one ||
        sums.odd[channel] > sums.sum[channel]) {
      return false;
    }
  }
  return true;
}

/// Checks one cell. Returns the fault, or nullptr. Sets the numbers of its samples and of its
/// non-finite samples.
const char* fault_of_cell(std::span<const std::byte> record, std::uint32_t pixels,
                          const RunSamples& ranges, std::uint32_t max_depth,
                          std::uint64_t& nonfinite, std::uint64_t& samples) {
  const CellHeader header = header_of(record);
  samples = 0;
  for (std::uint32_t i = 0; i < pixels; ++i) samples += ranges[i].count();
  if (header.rays > samples * max_depth * TraceCounts::rays_of_segment ||
      header.nonfinite > samples || header.lost > samples * (TraceCounts::lost_of(1) + 1)) {
    return "counts that are impossible for its samples";
  }
  for (std::uint32_t i = 0; i < pixels; ++i) {
    PixelSums sums;
    std::memcpy(&sums, record.data() + sizeof(CellHeader) + i * sizeof sums, sizeof sums);
    if (!within_bounds(sums, ranges[i].count())) return "sums that are impossible for its samples";
  }
  nonfinite = header.nonfinite;
  return nullptr;
}

/// Finds cells of a batch by row, first column and first sample.
using CellPlaces = std::map<std::array<std::uint32_t, 3>, std::uint64_t>;

CellPlaces places_of(const CellBatch& batch) {
  CellPlaces places;
  for (std::uint64_t index = batch.range.begin; index < batch.range.end; ++index) {
    const Cell cell = batch.grid->cell(index);
    places.emplace(std::array{cell.y, cell.x_begin, cell.samples.begin}, index);
  }
  return places;
}

/// Returns the first column of the cells that hold samples of the pixel; exactly one lattice has
/// the pixel.
std::optional<std::uint32_t> first_column(const ExcludedSamples& some, const GridShape& shape) {
  for (const Stage& stage : shape.stages) {
    const Lattice& lattice = stage.lattice;
    if (some.x % lattice.step == lattice.x && some.y % lattice.step == lattice.y) {
      const std::uint32_t pixel = some.x / lattice.step;
      return lattice.x + (pixel - pixel % shape.cell_pixels) * lattice.step;
    }
  }
  return {};
}

/// Returns the cell that holds sample `some.first` of its pixel, if it also holds the samples that
/// follow.
std::optional<std::uint64_t> cell_of(const ExcludedSamples& some, const CellPlaces& places,
                                     const CellBatch& batch) {
  const auto column = first_column(some, batch.grid->shape());
  auto found = column ? places.upper_bound({some.y, *column, some.first}) : places.begin();
  if (found == places.begin()) return {};
  --found;
  const Cell cell = batch.grid->cell(found->second);
  if (cell.y != some.y || cell.x_begin != *column || some.x >= cell.x_end) return {};
  const SampleRange own = batch.run_samples(found->second)[(some.x - cell.x_begin) / cell.step];
  const bool has = some.first >= own.begin && some.first < own.end && some.count >= 1 &&
                   some.count <= own.end - some.first;
  return has ? std::optional(found->second) : std::nullopt;
}

/// Checks that the excluded samples account for every missing sample, in order and once each.
/// `nonfinite` has one number per cell.
const char* fault_of_excluded(const std::vector<ExcludedSamples>& excluded, const CellBatch& batch,
                              std::vector<std::uint64_t> nonfinite) {
  const CellPlaces places = excluded.empty() ? CellPlaces() : places_of(batch);
  const ExcludedSamples* before = nullptr;
  std::uint64_t before_in = 0;
  for (const ExcludedSamples& some : excluded) {
    const std::optional<std::uint64_t> cell = cell_of(some, places, batch);
    if (!cell) return "excluded samples that its cells do not have";
    const bool again =
        before != nullptr && before->y == some.y && before->x == some.x && before_in == *cell;
    if (before != nullptr && (again || !(*before < some))) {
      return "excluded samples that are repeated or out of order";
    }
    std::uint64_t& left = nonfinite[*cell - batch.range.begin];
    if (some.count > left) return "more excluded samples than non-finite samples";
    left -= some.count;
    before = &some;
    before_in = *cell;
  }
  const bool all = std::ranges::all_of(nonfinite, [](std::uint64_t left) { return left == 0; });
  return all ? nullptr : "fewer excluded samples than non-finite samples";
}

}  // namespace

std::string fault_of(const TracedCells& traced, const CellBatch& batch, std::uint32_t max_depth) {
  return fault_of(traced, batch, batch.grid->cells_of(batch.range), max_depth);
}

std::string fault_of(const TracedCells& traced, const CellBatch& batch, std::span<const Cell> cells,
                     std::uint32_t max_depth) {
  const std::size_t size = record_bytes(batch.grid->shape().cell_pixels);
  constexpr const char* others = "other cells than were leased";
  if (!(traced.range == batch.range) || traced.records.size() != batch.range.count() * size) {
    return others;
  }
  std::uint64_t all_samples = 0;
  std::vector<std::uint64_t> nonfinite(batch.range.count());
  const std::span<const std::byte> records(traced.records);
  for (std::uint64_t i = 0; i < batch.range.count(); ++i) {
    std::uint64_t samples = 0;
    if (const char* fault = fault_of_cell(records.subspan(i * size, size), cells[i].pixels(),
                                          batch.run_samples(batch.range.begin + i, cells[i]),
                                          max_depth, nonfinite[i], samples)) {
      return fault;
    }
    all_samples += samples;
  }
  if (traced.samples != all_samples) return others;
  const char* fault = fault_of_excluded(traced.excluded, batch, std::move(nonfinite));
  return fault == nullptr ? "" : fault;
}

std::string pack_cells(const TracedCells& traced, const CellGrid& grid) {
  std::string bytes;
  const auto put = [&bytes](const auto& value) {
    bytes.append(reinterpret_cast<const char*>(&value), sizeof value);
  };
  const std::size_t size = record_bytes(grid.shape().cell_pixels);
  const std::span<const std::byte> records(traced.records);
  std::vector<PixelSums> sums;
  for (std::uint64_t i = 0; i < traced.range.count(); ++i) {
    const auto record = records.subspan(i * size, size);
    const CellHeader header = header_of(record);
    put(header.rays);
    put(header.nonfinite);
    put(header.lost);
    sums.resize(grid.cell(traced.range.begin + i).pixels());
    copy_sums(record, sums);
    pack_sums(sums, bytes);
  }
  for (const ExcludedSamples& some : traced.excluded) {
    put(std::array{some.y, some.x, some.first, some.count});
  }
  return bytes;
}

TracedCells unpack_cells(std::string_view bytes, const CellBatch& batch, std::uint32_t max_depth) {
  // Checks the size before the cells take memory.
  if (bytes.size() / least_cell_bytes < batch.range.count()) {
    throw DecodeError("a result with fewer cells than its lease");
  }
  ByteReader in(bytes);
  const std::size_t size = record_bytes(batch.grid->shape().cell_pixels);
  TracedCells traced;
  traced.range = batch.range;
  traced.samples = batch.sample_count();
  traced.records.resize(batch.range.count() * size);
  std::vector<PixelSums> sums(batch.grid->shape().cell_pixels);
  std::vector<std::uint64_t> nonfinite(batch.range.count());
  const char* fault = nullptr;
  std::uint64_t samples = 0;
  for (std::uint64_t i = 0; i < batch.range.count() && fault == nullptr; ++i) {
    const std::uint64_t index = batch.range.begin + i;
    const std::span<PixelSums> cell(sums.data(), batch.grid->cell(index).pixels());
    CellHeader header;
    header.rays = in.get<std::uint64_t>();
    header.nonfinite = in.get<std::uint64_t>();
    header.lost = in.get<std::uint64_t>();
    in.get_bytes(unpack_sums(bytes.substr(bytes.size() - in.left()), cell));
    const auto record = std::span(traced.records).subspan(i * size, size);
    std::memcpy(record.data(), &header, sizeof header);
    std::memcpy(record.data() + sizeof header, cell.data(), cell.size_bytes());
    // Checks each cell while it is in the cache, because there may be many cells.
    fault = fault_of_cell(record, static_cast<std::uint32_t>(cell.size()), batch.run_samples(index),
                          max_depth, nonfinite[i], samples);
  }
  while (fault == nullptr && in.left() > 0) {
    ExcludedSamples some;
    some.y = in.get<std::uint32_t>();
    some.x = in.get<std::uint32_t>();
    some.first = in.get<std::uint32_t>();
    some.count = in.get<std::uint32_t>();
    traced.excluded.push_back(some);
  }
  fault =
      fault != nullptr ? fault : fault_of_excluded(traced.excluded, batch, std::move(nonfinite));
  if (fault != nullptr) throw DecodeError(std::string("a result with ") + fault);
  return traced;
}

}  // namespace parray::schedule
