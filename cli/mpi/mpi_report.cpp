#include "cli/mpi/mpi_report.h"

namespace parray::mpi {

using nlohmann::json;

static double ratio(double a, double b) { return b > 0 ? a / b : 0; }

/// Those that returned wrong bits.
static json faulty_ranks(const std::vector<RankJudge::Verdict>& verdicts, const Ranks& ranks) {
  json list = json::array();
  for (const RankJudge::Verdict& verdict : verdicts) {
    list.push_back({{"rank", verdict.rank ? json(*verdict.rank) : json()},
                    {"host", verdict.rank ? ranks.facts[*verdict.rank].host : ""},
                    {"retraced_cells", verdict.cells},
                    {"restarted", verdict.restarted},
                    {"left_out", verdict.left_out}});
  }
  return list;
}

json mpi_report(const MpiCoordinator& coordinator, const Ranks& ranks, MpiMode mode,
                const char* transport, double render_seconds, bool row_seconds) {
  double takes = 0;
  double taking = 0;
  double putting = 0;
  json list = json::array();
  for (std::uint32_t rank = 0; rank < ranks.count; ++rank) {
    const auto value = [&](WindowLayout::RankWord word) {
      return static_cast<double>(coordinator.rank_value(rank, word));
    };
    takes += value(WindowLayout::takes);
    taking += value(WindowLayout::taking);
    putting += value(WindowLayout::putting);
    const double busy = 1e-9 * value(WindowLayout::busy);
    list.push_back({{"host", ranks.facts[rank].host},
                    {"threads", ranks.facts[rank].threads},
                    {"samples", coordinator.rank_value(rank, WindowLayout::samples)},
                    {"leases", coordinator.rank_value(rank, WindowLayout::takes)},
                    {"busy_seconds", busy},
                    {"normalized_seconds", ratio(busy, render_seconds)}});
  }
  const WindowCollector::Totals& totals = coordinator.totals();
  json map = {
      {"mode", name_of(mode)},
      {"transport", transport},
      {"leases", takes},
      {"microseconds_per_lease", 1e-3 * ratio(taking, takes)},
      {"microseconds_per_result", 1e-3 * ratio(putting, static_cast<double>(totals.entries))},
      {"copies", totals.copies},
      {"duplicate_cells", totals.duplicates},
      {"mismatched_cells", totals.mismatches},
      {"corrupt_results", totals.corrupt},
      {"faulty_ranks", faulty_ranks(coordinator.verdicts(), ranks)},
      {"ranks", std::move(list)}};
  if (row_seconds) {
    json& rows = map["row_seconds"] = json::array();  // by image row, top first
    for (const std::uint64_t nanoseconds : totals.row_nanoseconds) {
      rows.push_back(1e-9 * static_cast<double>(nanoseconds));
    }
  }
  return map;
}

}  // namespace parray::mpi
