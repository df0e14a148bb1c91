#include "cli/check/doctor/check.h"

#include <algorithm>
#include <utility>

#include "common/process/stop_signal.h"

namespace parray::doctor {

std::string_view name_of(CheckStatus status) {
  switch (status) {
    case CheckStatus::ok:
      return "ok";
    case CheckStatus::warning:
      return "warning";
    case CheckStatus::failed:
      return "failed";
    default:
      return "skipped";
  }
}

namespace {

Finding finding(CheckStatus status, std::string detail, std::string remedy) {
  Finding result;
  result.status = status;
  result.detail = std::move(detail);
  result.remedy = std::move(remedy);
  return result;
}

}  // namespace

Finding passed(std::string detail) { return finding(CheckStatus::ok, std::move(detail), {}); }
Finding warned(std::string detail, std::string remedy) {
  return finding(CheckStatus::warning, std::move(detail), std::move(remedy));
}
Finding failed(std::string detail, std::string remedy) {
  return finding(CheckStatus::failed, std::move(detail), std::move(remedy));
}
Finding skipped(std::string detail, std::string remedy) {
  return finding(CheckStatus::skipped, std::move(detail), std::move(remedy));
}

Finding run(const Check& check) {
  Finding found;
  try {
    found = check.run();
  } catch (const Interrupted&) {
    throw;
  } catch (const std::exception& error) {
    found = failed(error.what(), "mend what the message names, then run parray doctor again");
  }
  found.name = check.name;
  return found;
}

std::size_t count_of(const std::vector<Finding>& findings, CheckStatus status) {
  return static_cast<std::size_t>(
      std::count_if(findings.begin(), findings.end(),
                    [status](const Finding& finding) { return finding.status == status; }));
}

}  // namespace parray::doctor
