#pragma once

#include <algorithm>
#include <cstdint>
#include <utility>
#include <vector>

#include "common/scene/settings.h"
#include "tests/support/dice.h"
#include "tests/support/rooms.h"
#include "tests/support/window_rig.h"

namespace parray::test {

/// The time that the collector waits for a put to arrive.
constexpr Time arrival_time = seconds(2);

/// A collector of made-up samples, and a rank that puts the results that a test gives it.
struct CollectorRig : WindowRig {
  explicit CollectorRig(const RenderSettings& its_settings, std::uint32_t tile = 0,
                        const std::vector<CellRange>& done = {})
      : WindowRig(its_settings, 3, tile, done),
        cells(plan().cells()),
        expected(made_framebuffer(settings)),
        rank(source()) {}

  void put(const CellRange& range, std::uint64_t nanoseconds = 7) {
    rank.put(range, made_records(plan(), range, nanoseconds));
  }
  /// Puts `range` with one wrong bit in the sums of its last cell. The digest is that of the right
  /// sums.
  void put_corrupt(const CellRange& range) {
    auto records = made_records(plan(), range);
    const auto digest = range_digest(cell_digests(records, layout.record_bytes()));
    records[records.size() - layout.record_bytes() + sizeof(CellHeader)] ^= std::byte{1};
    window.put(layout.record_offset(range.begin), records);
    rank.log(range, digest);
  }
  /// Issues copies until the collector is done, and puts a result for each.
  void trace_copies(Time& now) {
    for (int i = 0; i < 100'000 && !collector.done(); ++i) {
      window.fetch_add(WindowLayout::copy_requests, 1);
      now += milliseconds(10);
      const std::uint64_t before = window.load(WindowLayout::copies);
      collector.issue_copies(now);
      for (std::uint64_t copy = before; copy < window.load(WindowLayout::copies); ++copy) {
        put(range_from_word(window.load(layout.copy_word(copy))));
      }
      collect(now);
    }
  }
  void check_picture() const {
    CHECK(collector.done());
    CHECK(same_sums(picture.framebuffer(), expected));
  }

  std::uint64_t cells;
  Framebuffer expected;
  WindowSource rank;
};

inline std::vector<CellRange> shuffled_ranges(Dice& dice, std::uint64_t cells) {
  std::vector<CellRange> ranges;
  for (std::uint64_t begin = 0; begin < cells;) {
    const std::uint64_t end = std::min(cells, begin + 1 + dice.below(9));
    ranges.push_back({begin, end});
    begin = end;
  }
  for (std::size_t i = ranges.size(); i > 1; --i) std::swap(ranges[i - 1], ranges[dice.below(i)]);
  return ranges;
}

inline RenderSettings random_settings(Dice& dice) {
  if (dice.one_in(4)) {  // rows that are divided into ranges of samples
    return made_settings(1 + dice.below32(3), 2 + dice.below32(9), 3000 + dice.below32(6000));
  }
  return made_settings(1 + dice.below32(40), 2 + dice.below32(12), 1 + dice.below32(400));
}

inline RenderSettings fixed_settings() { return made_settings(30, 9, 150); }

}  // namespace parray::test
