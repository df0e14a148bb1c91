#pragma once

#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "cli/measure/tradeoff/bench.h"
#include "cli/measure/tradeoff/findings.h"
#include "cli/measure/tradeoff/journal.h"
#include "cli/measure/tradeoff/reference.h"
#include "proto/clock.h"

namespace parray::tradeoff {

/// What is to be measured.
struct Request {
  RenderSettings scene;                ///< the scene's own, resolved, with its own size
  RenderSettings base;                 ///< the same with the size to measure at
  std::vector<RenderSettings> also{};  ///< more settings to measure
  std::optional<double> error;         ///< RMSE asked for; none: that of the scene's own settings
  double seconds = 120;                ///< for everything
};

/// Measures a trade, stage by stage, into a journal: what is there already is not measured again.
/// One thread.
class Session {
 public:
  /// All must outlive it. `show` hears of the share that is done, 0 .. 1, several times a second.
  Session(const Request& request, Bench& bench, Journal& journal, std::function<void(double)> show);

  /// Throws Interrupted; the journal has what was measured until then.
  [[nodiscard]] Findings measure();

 private:
  /// A part of the whole, for progress.
  struct Stage {
    double from = 0;
    double share = 0;
  };
  void show(const Stage& stage, double done) const;

  Pilot pilot();
  double speed_of(const RenderSettings& settings, std::uint32_t samples) const;
  void make_reference();
  void sweep();
  void measure_run(const RenderSettings& settings, std::uint32_t run);
  void keep(Run measured, const RenderSettings& settings, const DirectRender& render);
  [[nodiscard]] bool planned(const RenderSettings& settings, std::uint32_t run) const;
  void measure_biases();
  [[nodiscard]] Occasion occasion();
  void find_answer(Findings& findings);
  const Row* measured(const RenderSettings& settings, Findings& findings);
  void refresh(Findings& findings) const;
  void add_notes(Findings& findings) const;

  const Request& request_;
  Bench& bench_;
  Journal& journal_;
  const std::function<void(double)> show_;
  const SteadyClock clock_;
  Reference reference_;
  Pilot pilot_;
  Sweep sweep_;
  PairedBiases biases_;
  std::size_t runs_missing_ = 0;
};

}  // namespace parray::tradeoff
