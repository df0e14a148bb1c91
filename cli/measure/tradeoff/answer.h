#pragma once

#include <optional>
#include <string>
#include <vector>

#include "cli/measure/tradeoff/analysis.h"
#include "cli/measure/tradeoff/bench.h"

/// The cheapest settings for an accuracy, from the measurements. Pure functions.
namespace parray::tradeoff {

/// Settings with the predicted time to reach an RMSE.
struct Candidate {
  Boxed<RenderSettings> settings;
  double seconds = 0;  ///< as Row::seconds, at the measured size
};

/// Returns the settings that are predicted to reach the RMSE `error` soonest: one candidate for
/// each way to sample, the fastest first. A way to sample is a sampler with equal numbers of
/// samples, with adaptive passes to a target error, or with equal numbers and denoising. Ways with
/// too few measurements are left out. A candidate has the scene's own depth, precision and
/// accelerator, unless others are predicted to be at least 5 % faster, or the systematic error of
/// the scene's own alone exceeds `error`. The square of the systematic error of such others may be
/// at most a tenth of the square of `error`. Denoised pictures always keep the scene's own. `base`:
/// the scene's own settings.
std::vector<Candidate> candidates_for(double error, const std::vector<Row>& rows,
                                      const RenderSettings& base, const PairedBiases& biases);

/// Returns the scene's own settings with the number of samples that `error` takes. Returns nothing
/// if the number is unknown, or if the scene's own settings are adaptive.
std::optional<Candidate> own_for(double error, const std::vector<Row>& rows,
                                 const RenderSettings& base);

/// Corrects the prediction after a measurement: returns the settings of `row` with the number of
/// samples, or the target error, that should give the RMSE `error`. Returns nothing if no
/// correction is needed. That is so if the RMSE of the row is at most 0.5 % above `error` and, for
/// settings without a target error, not more than 3 % below it. Also returns nothing if the
/// corrected settings equal those of the row, or if the RMSE of the row is not known.
std::optional<Candidate> corrected(const Row& row, double error);

/// Returns the fastest row whose RMSE is known and at most 0.5 % above `error`. Null: there is
/// none.
const Row* fastest_within(double error, const std::vector<Row>& rows);

/// Returns the row of these settings. Null: there is none.
const Row* row_with(const std::vector<Row>& rows, const RenderSettings& settings);

/// Returns whether settings of one scene differ only in the number of samples or in the value of a
/// target error. Does not compare size and seed.
bool same_but_samples(const RenderSettings& a, const RenderSettings& b);

/// The facts that sentence_of() turns into text: the answer of `parray tradeoff`.
struct Answer {
  double error = 0;  ///< required RMSE
  /// The user stated `error`; false: it is the RMSE of the scene's own settings.
  bool asked = false;
  Row pick;          ///< the fastest measured settings with at most this error
  bool own = false;  ///< `pick` has the scene's own settings, apart from the samples
  /// Time in which the scene's own settings reach `error`; 0: unknown.
  double own_seconds = 0;
  std::string own_options;  ///< options of those settings; empty: unknown
  /// The scene's own settings; `pick` may be measured in a smaller picture.
  Boxed<RenderSettings> scene;
};
/// Returns the answer as a text for people.
std::string sentence_of(const Answer& answer);

}  // namespace parray::tradeoff
