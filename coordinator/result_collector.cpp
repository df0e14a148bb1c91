#include "coordinator/result_collector.h"

#include <xxhash.h>

#include <algorithm>

namespace parray {
namespace {

/// Neighbours joined.
std::vector<CellRange> ranges_of(std::vector<std::uint64_t> cells) {
  std::sort(cells.begin(), cells.end());
  std::vector<CellRange> ranges;
  for (const std::uint64_t cell : cells) {
    if (!ranges.empty() && cell < ranges.back().end) {
      continue;  // named twice
    }
    if (!ranges.empty() && ranges.back().end == cell) {
      ++ranges.back().end;
    } else {
      ranges.push_back({cell, cell + 1});
    }
  }
  return ranges;
}

}  // namespace

ResultCollector::ResultCollector(std::shared_ptr<const WorkPlan> plan, Framebuffer& framebuffer)
    : plan_(std::move(plan)), framebuffer_(framebuffer), cells_(plan_->cells()) {}

std::uint32_t ResultCollector::place_of(TracerKey tracer) {
  const auto found = std::find(tracers_.begin(), tracers_.end(), tracer);
  if (found != tracers_.end()) {
    return static_cast<std::uint32_t>(found - tracers_.begin());
  }
  tracers_.push_back(tracer);
  return static_cast<std::uint32_t>(tracers_.size() - 1);
}

static bool is_of(const ExcludedSamples& some, const Cell& cell) {
  return some.y == cell.y && some.x >= cell.x_begin && some.x < cell.x_end &&
         some.first >= cell.samples.begin && some.first < cell.samples.end;
}

/// `digests`: of the records, which do not say which samples were left out.
std::vector<std::uint64_t> ResultCollector::digests_of(const TracedCells& traced,
                                                       std::vector<std::uint64_t> digests) const {
  const std::size_t size = record_size();
  for (std::size_t i = 0; i < digests.size(); ++i) {
    if (header_of(std::span(traced.records).subspan(i * size, size)).nonfinite == 0) {
      continue;
    }
    const Cell cell = plan_->cell(traced.range.begin + i);
    for (const ExcludedSamples& some : traced.excluded) {
      if (is_of(some, cell)) {
        const std::uint64_t digest = XXH3_64bits_withSeed(&some, sizeof some, digests[i]);
        digests[i] = digest == 0 ? 1 : digest;  // 0 stands for cells that are not in
      }
    }
  }
  return digests;
}

ResultCollector::Taken ResultCollector::take(TracerKey tracer, const TracedCells& traced,
                                             std::vector<std::uint64_t> digests,
                                             std::span<const Cell> cells) {
  digests = digests_of(traced, std::move(digests));
  const std::size_t size = record_size();
  const std::uint32_t place = place_of(tracer);
  const CellBatch batch = plan_->batch(traced.range);
  Taken taken;
  for (std::uint64_t i = 0; i < traced.range.count(); ++i) {
    const std::uint64_t index = traced.range.begin + i;
    const auto record = std::span(traced.records).subspan(i * size, size);
    const std::uint64_t digest = digests[i];
    Done& done = cells_[index];
    if (i + 1 < cells.size()) {
      framebuffer_.expect(cells[i + 1].y, cells[i + 1].x_begin);
    }
    if (done.digest == 0) {
      merge(batch, index, cells[i], digest, record, place, taken);
      if (done.nonfinite > 0) {
        exclude_some(cells[i], traced.excluded);
      }
    } else if (done.digest != digest) {
      ++taken.mismatches;
    } else {
      ++taken.duplicates;
      done.tracer = done.tracer == place ? place : confirmed;
    }
  }
  return taken;
}

void ResultCollector::merge(const CellBatch& batch, std::uint64_t index, const Cell& cell,
                            std::uint64_t digest, std::span<const std::byte> record,
                            std::uint32_t tracer, Taken& taken) {
  const CellHeader header = header_of(record);
  sums_.resize(cell.pixels());
  copy_sums(record, sums_);
  const RunSamples ranges = batch.run_samples(index, cell);
  framebuffer_.add(cell.y, cell.x_begin, sums_, ranges, cell.step);
  std::uint64_t samples = 0;
  for (std::uint32_t i = 0; i < cell.pixels(); ++i) {
    samples += ranges[i].count();
  }
  framebuffer_.add(TraceCounts{samples, header.rays, header.nonfinite, header.lost});
  cells_[index] = {digest, header.rays, header.lost, static_cast<std::uint32_t>(header.nonfinite),
                   tracer};
  ++done_;
  ++taken.fresh;
  taken.fresh_samples += samples;
}

/// Those of one cell: others may be in already.
void ResultCollector::exclude_some(const Cell& cell, const std::vector<ExcludedSamples>& excluded) {
  for (const ExcludedSamples& some : excluded) {
    if (is_of(some, cell)) {
      framebuffer_.exclude(some);
    }
  }
}

ResultCollector::Taken ResultCollector::compare(const CellRange& range,
                                                const std::vector<std::uint64_t>& digests) {
  Taken taken;
  for (std::uint64_t i = 0; i < range.count(); ++i) {
    Done& done = cells_[range.begin + i];
    if (done.digest == 0) {
      continue;
    }
    if (done.digest == digests[i]) {
      ++taken.duplicates;
      done.tracer = confirmed;
    } else {
      ++taken.mismatches;
    }
  }
  return taken;
}

std::vector<std::uint64_t> ResultCollector::digests(const CellRange& range) const {
  std::vector<std::uint64_t> digests;
  for (std::uint64_t index = range.begin; index < range.end; ++index) {
    digests.push_back(cells_[index].digest);
  }
  return digests;
}

std::optional<TracerKey> ResultCollector::tracer_of(
    const CellRange& range, const std::vector<std::uint64_t>& digests) const {
  for (std::uint64_t i = 0; i < range.count(); ++i) {
    const Done& done = cells_[range.begin + i];
    if (done.digest != 0 && done.digest != digests[i]) {
      return done.tracer == confirmed ? std::nullopt : std::optional(tracers_[done.tracer]);
    }
  }
  return {};
}

void ResultCollector::clear_pixels(std::uint64_t index, std::vector<std::uint64_t>& cleared) {
  TraceCounts counts;
  for (const std::uint64_t same : plan_->grid()->cells_of_same_pixels(index)) {
    Done& done = cells_[same];
    if (done.digest != 0) {
      counts += TraceCounts{plan_->batch({same, same + 1}).sample_count(), done.rays,
                            done.nonfinite, done.lost};
      done = {};
      --done_;
      cleared.push_back(same);
    }
  }
  const Cell cell = plan_->cell(index);
  framebuffer_.clear(cell.y, cell.x_begin, cell.x_end, counts, cell.step);
}

std::vector<CellRange> ResultCollector::retract(TracerKey tracer) {
  const std::uint32_t place = place_of(tracer);
  std::vector<std::uint64_t> cleared;
  for (std::uint64_t index = 0; index < cells_.size(); ++index) {
    if (cells_[index].digest != 0 && cells_[index].tracer == place) {
      clear_pixels(index, cleared);
    }
  }
  return ranges_of(std::move(cleared));
}

std::vector<CellRange> ResultCollector::retract(const std::vector<CellRange>& ranges) {
  std::vector<std::uint64_t> cleared;
  for (const CellRange& range : ranges) {
    for (std::uint64_t index = range.begin; index < range.end; ++index) {
      if (cells_[index].digest != 0) {
        clear_pixels(index, cleared);
      }
    }
  }
  return ranges_of(std::move(cleared));
}

bool ResultCollector::relies_on(TracerKey tracer) const {
  const auto found = std::find(tracers_.begin(), tracers_.end(), tracer);
  const auto place = static_cast<std::uint32_t>(found - tracers_.begin());
  return found != tracers_.end() && std::any_of(cells_.begin(), cells_.end(), [&](const Done& d) {
           return d.digest != 0 && d.tracer == place;
         });
}

CellRange ResultCollector::next_missing(std::uint64_t from, std::uint64_t most) const {
  while (from < cells_.size() && cells_[from].digest != 0) {
    ++from;
  }
  CellRange range{from, from};
  while (range.end < cells_.size() && cells_[range.end].digest == 0 && range.count() < most) {
    ++range.end;
  }
  return range;
}

std::vector<CellRange> ResultCollector::missing() const {
  std::vector<CellRange> all;
  for (CellRange range = next_missing(0, cells_.size()); range.count() > 0;
       range = next_missing(range.end, cells_.size())) {
    all.push_back(range);
  }
  return all;
}

}  // namespace parray
