#include "cli/mpi/mpi_report.h"

#include <algorithm>

#include "common/schedule/row_order.h"

namespace parray {
namespace {

using nlohmann::json;

double ratio(double a, double b) { return b > 0 ? a / b : 0; }

/// By image row, top first.
json row_seconds_of(const RenderSettings& settings, const WindowLedger& ledger) {
  const auto row_at = make_row_order(settings.row_order, settings.height);
  std::vector<double> seconds(settings.height);
  for (std::size_t position = 0; position < row_at.size(); ++position) {
    seconds[row_at[position]] = 1e-9 * static_cast<double>(ledger.row_nanoseconds()[position]);
  }
  return seconds;
}

}  // namespace

json mpi_report(const Job& job, const Transport& transport, MpiMode mode,
                const std::vector<RankFacts>& ranks, const WindowLayout& layout,
                WindowLedger& ledger, double render_seconds, bool row_seconds) {
  double takes = 0;
  double taking = 0;
  double putting = 0;
  json list = json::array();
  for (std::uint32_t rank = 0; rank < layout.ranks(); ++rank) {
    const auto value = [&](WindowLayout::RankWord word) {
      return static_cast<double>(ledger.rank_value(rank, word));
    };
    takes += value(WindowLayout::takes);
    taking += value(WindowLayout::taking);
    putting += value(WindowLayout::putting);
    const double busy = 1e-9 * value(WindowLayout::busy);
    list.push_back({{"host", ranks[rank].host},
                    {"threads", ranks[rank].threads},
                    {"samples", ledger.rank_value(rank, WindowLayout::samples)},
                    {"leases", ledger.rank_value(rank, WindowLayout::takes)},
                    {"busy_seconds", busy},
                    {"normalized_seconds", ratio(busy, render_seconds)}});
  }
  const WindowLedger::Tally& tally = ledger.tally();
  json map = {
      {"mode", name_of(mode)},
      {"transport", transport.name()},
      {"leases", takes},
      {"microseconds_per_lease", 1e-3 * ratio(taking, takes)},
      {"microseconds_per_result", 1e-3 * ratio(putting, static_cast<double>(tally.entries))},
      {"copies", tally.copies},
      {"duplicate_cells", tally.duplicates},
      {"mismatched_cells", tally.mismatches},
      {"corrupt_results", tally.corrupt},
      {"ranks", std::move(list)}};
  if (row_seconds) {
    map["row_seconds"] = row_seconds_of(job.record.settings, ledger);
  }
  return map;
}

void note_ranks(Job& job, const std::vector<RankFacts>& ranks, const WindowLayout& layout,
                WindowLedger& ledger) {
  JobWork& work = *job.work;
  for (std::uint32_t rank = 0; rank < layout.ranks(); ++rank) {
    work.contributors.insert(rank);
    work.contributor_threads += ranks[rank].threads;
    const double build = 1e-9 * static_cast<double>(ledger.rank_value(rank, WindowLayout::build));
    work.build_seconds = std::max(work.build_seconds, build);
    work.accelerator_bytes =
        std::max(work.accelerator_bytes, ledger.rank_value(rank, WindowLayout::tree_bytes));
  }
}

}  // namespace parray
