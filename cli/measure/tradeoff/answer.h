#pragma once

#include <optional>
#include <string>
#include <vector>

#include "cli/measure/tradeoff/analysis.h"
#include "cli/measure/tradeoff/paired.h"

/// The cheapest settings for an accuracy, from the measurements. Pure functions.
namespace parray::tradeoff {

/// Settings with the predicted time to reach an RMSE.
struct Candidate {
  Boxed<RenderSettings> settings;
  double seconds = 0;
};

/// Returns, for each way to place samples (sampler, uniform or to a target, denoised or not), the
/// settings predicted to reach `error` soonest, the cheapest first. Another depth or precision than
/// the scene's must be at least 5 % faster, and its systematic error may be at most a tenth of the
/// mean square. Denoised pictures keep the scene's depth and precision.
std::vector<Candidate> candidates_for(double error, const std::vector<Row>& rows,
                                      const RenderSettings& base, const PairedBiases& biases);

/// Returns the scene's own settings with the number of samples that `error` takes, or nothing if
/// the number is unknown.
std::optional<Candidate> own_for(double error, const std::vector<Row>& rows,
                                 const RenderSettings& base);

/// Returns the settings of `row`, which missed `error`, with a corrected number of samples or
/// target. Returns nothing if the measured error is close enough.
std::optional<Candidate> corrected(const Row& row, double error);

/// Returns the fastest row with at most that RMSE, or null.
const Row* fastest_within(double error, const std::vector<Row>& rows);

/// Returns whether the settings differ only in the number of samples or the target.
bool same_but_samples(const RenderSettings& a, const RenderSettings& b);

/// The contents of the sentence.
struct Answer {
  double error = 0;
  bool asked = false;           ///< false: `error` is the RMSE of the scene's own settings
  Row pick;                     ///< measured
  bool own = false;             ///< `pick` has the scene's own settings, apart from the samples
  double own_seconds = 0;       ///< time of the scene's own settings to reach `error`
  std::string own_options;      ///< options of those settings; empty: unknown
  Boxed<RenderSettings> scene;  ///< with the size of the scene's own picture
};
std::string sentence_of(const Answer& answer);

}  // namespace parray::tradeoff
