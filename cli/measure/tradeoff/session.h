#pragma once

#include <functional>
#include <optional>
#include <vector>

#include "cli/measure/tradeoff/measurement_log.h"
#include "cli/measure/tradeoff/tradeoff_results.h"

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

/// Makes the measurements of `parray tradeoff`, writes them to `log`, and returns the results.
/// Skips measurements that the log already has. After the pilot (short first renders, see Pilot),
/// calls `show` after most renders with the completed share of the session, 0 to 1. Throws
/// Interrupted after an interrupt of the user; the log then has the measurements made until then.
/// Throws InputError if the log is damaged, and RunError if the time does not suffice for the
/// scene's own settings.
TradeoffResults measure_tradeoff(const Request& request, Bench& bench, MeasurementLog& log,
                                 const std::function<void(double)>& show);

}  // namespace parray::tradeoff
