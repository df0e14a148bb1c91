#include "coordinator/leases/result_collector.h"

#include <xxhash.h>

#include <algorithm>

namespace parray::coordinator {

/// Converts cells to ranges and joins adjacent ones.
static std::vector<CellRange> ranges_of(std::vector<std::uint64_t> cells) {
  std::ranges::sort(cells);
  std::vector<CellRange> ranges;
  for (const std::uint64_t cell : cells) {
    if (!ranges.empty() && cell < ranges.back().end) {
      continue;  // a duplicate
    }
    if (!ranges.empty() && ranges.back().end == cell) {
      ++ranges.back().end;
    } else {
      ranges.push_back({cell, cell + 1});
    }
  }
  return ranges;
}

ResultCollector::ResultCollector(std::shared_ptr<const WorkPlan> plan, Framebuffer& framebuffer)
    : plan_(std::move(plan)), framebuffer_(framebuffer), cells_(plan_->cells()) {}

std::uint32_t ResultCollector::place_of(TracerKey tracer) {
  const auto found = std::ranges::find(tracers_, tracer);
  if (found != tracers_.end()) return static_cast<std::uint32_t>(found - tracers_.begin());
  tracers_.push_back(tracer);
  return static_cast<std::uint32_t>(tracers_.size() - 1);
}

static bool is_of(const ExcludedSamples& some, const Cell& cell) {
  return some.y == cell.y && some.x >= cell.x_begin && some.x < cell.x_end &&
         some.first >= cell.samples.begin && some.first < cell.samples.end;
}

/// `digests`: those of the records, which do not contain the excluded samples.
std::vector<std::uint64_t> ResultCollector::digests_of(const TracedCells& traced,
                                                       std::vector<std::uint64_t> digests) const {
  const std::size_t size = record_size();
  for (std::size_t i = 0; i < digests.size(); ++i) {
    if (header_of(std::span(traced.records).subspan(i * size, size)).nonfinite == 0) continue;
    const Cell cell = plan_->cell(traced.range.begin + i);
    for (const ExcludedSamples& some : traced.excluded) {
      if (is_of(some, cell)) {
        const std::uint64_t digest = XXH3_64bits_withSeed(&some, sizeof some, digests[i]);
        digests[i] = digest == 0 ? 1 : digest;  // 0 stands for cells that are not merged
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
    if (i + 1 < cells.size()) framebuffer_.expect(cells[i + 1].y, cells[i + 1].x_begin);
    if (done.digest == 0) {
      merge(batch, index, cells[i], digest, record, place, taken);
      if (done.nonfinite > 0) exclude_some(cells[i], traced.excluded);
    } else if (done.digest != digest) {
      ++taken.mismatches;
    } else {
      ++taken.duplicates;
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
  for (std::uint32_t i = 0; i < cell.pixels(); ++i) samples += ranges[i].count();
  framebuffer_.add(TraceCounts{samples, header.rays, header.nonfinite, header.lost});
  cells_[index] = {digest, header.rays, header.lost, static_cast<std::uint32_t>(header.nonfinite),
                   tracer};
  ++done_;
  ++taken.fresh;
  taken.fresh_samples += samples;
}

/// Excludes the samples of one cell; other cells of the result may be merged already.
void ResultCollector::exclude_some(const Cell& cell, const std::vector<ExcludedSamples>& excluded) {
  for (const ExcludedSamples& some : excluded) {
    if (is_of(some, cell)) framebuffer_.exclude(some);
  }
}

ResultCollector::Taken ResultCollector::compare(const CellRange& range,
                                                const std::vector<std::uint64_t>& digests) const {
  Taken taken;
  for (std::uint64_t i = 0; i < range.count(); ++i) {
    const Done& done = cells_[range.begin + i];
    if (done.digest == digests[i]) {
      ++taken.duplicates;
    } else if (done.digest != 0) {
      ++taken.mismatches;
    }
  }
  return taken;
}

void ResultCollector::note_check(TracerKey tracer, const CellRange& range) {
  checks_.push_back({range, place_of(tracer)});
  for (std::uint64_t cell = range.begin; cell < range.end; ++cell) {
    if (cells_[cell].digest == 0) {
      forget_checks_of_missing();
      return;
    }
  }
}

bool ResultCollector::is_checked(std::uint64_t cell) const {
  return std::ranges::any_of(checks_, [&](const Check& check) {
    return check.range.begin <= cell && cell < check.range.end &&
           check.tracer != cells_[cell].tracer;
  });
}

/// Returns for each cell whether it is merged and checked.
std::vector<bool> ResultCollector::checked() const {
  std::vector<bool> checked(cells_.size());
  for (const Check& check : checks_) {
    for (std::uint64_t cell = check.range.begin; cell < check.range.end; ++cell) {
      const Done& done = cells_[cell];
      checked[cell] = checked[cell] || (done.digest != 0 && done.tracer != check.tracer);
    }
  }
  return checked;
}

std::uint64_t ResultCollector::checked_cells() const {
  const std::vector<bool> cells = checked();
  return static_cast<std::uint64_t>(std::ranges::count(cells, true));
}

std::vector<ResultCollector::Unchecked> ResultCollector::unchecked_cells(std::uint64_t most) const {
  return unchecked_among(std::vector<bool>(cells_.size(), true), most);
}

std::vector<ResultCollector::Unchecked> ResultCollector::wanted_cells(std::uint64_t most) const {
  if (wanted_.empty()) return {};
  std::vector<bool> wanted(cells_.size());
  for (const CellRange& range : wanted_) {
    std::fill_n(wanted.begin() + static_cast<std::ptrdiff_t>(range.begin), range.count(), true);
  }
  return unchecked_among(wanted, most);
}

std::vector<ResultCollector::Unchecked> ResultCollector::unchecked_among(
    const std::vector<bool>& some, std::uint64_t most) const {
  const std::vector<bool> done = checked();
  std::vector<Unchecked> found;
  for (std::uint64_t cell = 0; cell < cells_.size(); ++cell) {
    if (some[cell] && cells_[cell].digest != 0 && !done[cell]) add_unchecked(found, cell, most);
  }
  return found;
}

/// Adds a cell that follows those in `list`. Ranges get at most `most` cells.
void ResultCollector::add_unchecked(std::vector<Unchecked>& list, std::uint64_t cell,
                                    std::uint64_t most) const {
  const TracerKey tracer = tracers_[cells_[cell].tracer];
  if (!list.empty() && list.back().range.end == cell && list.back().tracer == tracer &&
      list.back().range.count() < most) {
    ++list.back().range.end;
  } else {
    list.push_back({{cell, cell + 1}, tracer});
  }
}

std::vector<ResultCollector::Differing> ResultCollector::differing(
    const CellRange& range, const std::vector<std::uint64_t>& digests) const {
  std::vector<Differing> differing;
  for (std::uint64_t i = 0; i < range.count(); ++i) {
    const Done& done = cells_[range.begin + i];
    if (done.digest != 0 && done.digest != digests[i]) {
      differing.push_back({range.begin + i, tracers_[done.tracer]});
    }
  }
  return differing;
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

/// Removes the checks of missing cells, because they do not apply to a new result.
void ResultCollector::forget_checks_of_missing() {
  std::vector<Check> kept;
  for (const Check& check : checks_) {
    bool open = false;
    for (std::uint64_t cell = check.range.begin; cell < check.range.end; ++cell) {
      if (cells_[cell].digest == 0) {
        open = false;
      } else if (open) {
        ++kept.back().range.end;
      } else {
        kept.push_back({{cell, cell + 1}, check.tracer});
        open = true;
      }
    }
  }
  checks_ = std::move(kept);
}

ResultCollector::Retraction ResultCollector::retract(TracerKey tracer) {
  const std::uint32_t place = place_of(tracer);
  std::vector<std::uint64_t> cleared;
  for (std::uint64_t index = 0; index < cells_.size(); ++index) {
    if (cells_[index].digest != 0 && cells_[index].tracer == place) clear_pixels(index, cleared);
  }
  forget_checks_of_missing();
  std::vector<Unchecked> unchecked;
  for (const Check& check : checks_) {
    for (std::uint64_t cell = check.range.begin; check.tracer == place && cell < check.range.end;
         ++cell) {
      add_unchecked(unchecked, cell, check.range.count());
    }
  }
  std::erase_if(checks_, [&](const Check& check) { return check.tracer == place; });
  return {ranges_of(std::move(cleared)), std::move(unchecked)};
}

std::vector<CellRange> ResultCollector::retract(const std::vector<CellRange>& ranges) {
  std::vector<std::uint64_t> cleared;
  for (const CellRange& range : ranges) {
    for (std::uint64_t index = range.begin; index < range.end; ++index) {
      if (cells_[index].digest != 0) clear_pixels(index, cleared);
    }
  }
  forget_checks_of_missing();
  return ranges_of(std::move(cleared));
}

bool ResultCollector::has_cells_of(TracerKey tracer) const {
  return std::ranges::any_of(cells_, [&](const Done& done) {
    return done.digest != 0 && tracers_[done.tracer] == tracer;
  });
}

bool ResultCollector::relies_on(TracerKey tracer) const {
  return has_cells_of(tracer) ||
         std::ranges::any_of(checks_, [&](const Check& c) { return tracers_[c.tracer] == tracer; });
}

CellRange ResultCollector::next_missing(std::uint64_t from, std::uint64_t most) const {
  while (from < cells_.size() && cells_[from].digest != 0) ++from;
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

}  // namespace parray::coordinator
