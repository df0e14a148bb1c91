#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "cli/measure/tradeoff/bench.h"
#include "cli/measure/tradeoff/measurement_log.h"
#include "cli/measure/tradeoff/reference.h"
#include "cli/measure/tradeoff/tradeoff_results.h"
#include "proto/clock.h"

namespace parray::tradeoff {

/// The task of a session.
struct Request {
  /// The scene's own settings and size; no value is `automatic`.
  Boxed<RenderSettings> scene;
  Boxed<RenderSettings> base;                 ///< the same settings with the measured size
  std::vector<Boxed<RenderSettings>> also{};  ///< more settings to measure, of --also
  std::optional<double> error;  ///< required RMSE; empty: that of the scene's own settings
  double seconds = 120;         ///< time for all measurements
};

/// Makes the measurements of `parray tradeoff` and writes them to a log. Skips measurements that
/// the log already has. Not thread-safe.
class Session {
 public:
  /// All arguments except `show` must outlive this object. After the pilot (short first renders,
  /// see Pilot), measure() calls `show` after most renders with the completed share of the session,
  /// 0 to 1.
  Session(const Request& request, Bench& bench, MeasurementLog& log,
          std::function<void(double)> show);

  /// Makes all measurements and returns the results. Throws Interrupted after an interrupt of the
  /// user; the log then has the measurements made until then. Throws InputError if the log is
  /// damaged, and RunError if the time does not suffice for the scene's own settings.
  [[nodiscard]] TradeoffResults measure();

 private:
  /// A part of the session, for the progress bar.
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
  [[nodiscard]] Environment environment();
  void find_answer(TradeoffResults& results);
  const Row* measured(const RenderSettings& settings, TradeoffResults& results);
  void refresh(TradeoffResults& results) const;
  void add_notes(TradeoffResults& results) const;

  const Request& request_;
  Bench& bench_;
  MeasurementLog& log_;
  const std::function<void(double)> show_;
  const SteadyClock clock_;
  Reference reference_;
  Pilot pilot_;
  Sweep sweep_;
  PairedBiases biases_;
  std::size_t runs_missing_ = 0;
};

}  // namespace parray::tradeoff
