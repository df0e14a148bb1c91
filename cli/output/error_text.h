#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>

#include "common/adaptive/error_estimate.h"

/// A picture's error as people read it.
namespace parray::farm {
struct JobStatus;
}

namespace parray::output {

/// "0.0094 (0.0092 to 0.0096)": RMSE and its interval, three digits; empty where unknown.
std::string figures_text(const ErrorFigures& error);

/// "error 0.0094 (0.0092 to 0.0096)" of a report's picture; "error not known" where it states none.
std::string error_text(const nlohmann::json& report);

/// "error 0.021 of 0.01": what is to fall to a job's target, the upper end of the RMSE's interval,
/// and the target; of a target half-width likewise. Empty without a target, and until it is known.
std::string target_text(const JobStatus& job);

}  // namespace parray::output
