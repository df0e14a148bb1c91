#pragma once

#include <optional>
#include <string>
#include <vector>

#include "cli/measure/tradeoff/analysis.h"
#include "cli/measure/tradeoff/paired.h"

/// The cheapest settings for an accuracy, from what has been measured. Pure functions.
namespace parray::tradeoff {

/// Settings that should reach an RMSE, and what they should cost.
struct Candidate {
  RenderSettings settings;
  double seconds = 0;
};

/// For each way to spend samples (sampler, uniform or to a target, denoised or not) the settings
/// that should reach `error` soonest, the cheapest first. A depth or a precision other than the
/// scene's own is taken only if its systematic error makes up a tenth of the mean square at most,
/// and if it is 5 % faster than the scene's own: less is not worth a bias, nor a measurement's
/// doubt. Pictures that are denoised keep the scene's own.
std::vector<Candidate> candidates_for(double error, const std::vector<Row>& rows,
                                      const RenderSettings& base, const PairedBiases& biases);

/// The scene's own settings with as many samples as `error` takes; none if that is unknown.
std::optional<Candidate> own_for(double error, const std::vector<Row>& rows,
                                 const RenderSettings& base);

/// Settings like those of `row`, which were to reach `error`, corrected by what came of them; none
/// if that is near enough.
std::optional<Candidate> corrected(const Row& row, double error);

/// The fastest of the rows with at most that RMSE; null if there is none.
const Row* fastest_within(double error, const std::vector<Row>& rows);

/// Whether both spend samples in the same way, however many.
bool same_but_samples(const RenderSettings& a, const RenderSettings& b);

/// What the sentence says.
struct Answer {
  double error = 0;
  bool asked = false;       ///< else it is the RMSE of the scene's own settings
  Row pick;                 ///< measured
  bool own = false;         ///< `pick` differs from the scene's own settings in samples at most
  double own_seconds = 0;   ///< time that the scene's own settings take to `error`
  std::string own_options;  ///< options of those settings; empty: unknown
  RenderSettings scene;     ///< with the size of the scene's own picture
};
std::string sentence_of(const Answer& answer);

}  // namespace parray::tradeoff
