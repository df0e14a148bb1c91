#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>

#include "common/adaptive/error_estimate.h"

/// The error of a picture as text.
namespace parray::farm {
struct JobStatus;
}

namespace parray::output {

/// Returns RMSE and its confidence interval with three digits: "0.0094 (0.0092 to 0.0096)". Returns
/// "" if they are unknown.
std::string figures_text(const ErrorFigures& error);

/// Returns the error in a report: "error 0.0094 (0.0092 to 0.0096)", or "error not known". For a
/// denoised picture, the error before denoising follows.
std::string error_text(const nlohmann::json& report);

/// Returns the error of a job and its target: "error 0.021 of 0.01", where 0.021 is the upper end
/// of the RMSE's confidence interval. For a target half-width: "half-width 0.1 of 0.05", where 0.1
/// is the 99th percentile of the pixels' half-widths. Returns "" without a target, and while the
/// error is unknown.
std::string target_text(const JobStatus& job);

}  // namespace parray::output
