#include "cli/output/error_text.h"

#include <nlohmann/json.hpp>

#include "cli/farm/client.h"
#include "cli/output/text.h"
#include "coordinator/jobs/report.h"

namespace parray::output {

static std::string figure(double value) { return formatted("%.3g", value); }

std::string figures_text(const ErrorFigures& error) {
  if (!error.known()) return "";
  return figure(error.rmse) + " (" + figure(error.low) + " to " + figure(error.high) + ")";
}

std::string error_text(const nlohmann::json& report) {
  const ErrorFigures error = error_from_json(report.value("error", nlohmann::json()));
  const std::string raw = error.known() ? figures_text(error) : "not known";
  const auto denoised = report.find("denoised");
  if (denoised == report.end()) return "error " + raw;
  return "error " + figures_text(error_from_json(*denoised)) + ", " + raw + " before denoising";
}

std::string target_text(const JobStatus& job) {
  std::string text;
  const auto add = [&text](const char* what, double value, double target) {
    if (target <= 0 || value < 0) return;
    text +=
        (text.empty() ? "" : ", ") + std::string(what) + figure(value) + " of " + figure(target);
  };
  add("error ", job.error.high, job.target_error);
  add("half-width ", job.error.half_width_p99, job.target_half_width);
  return text;
}

}  // namespace parray::output
