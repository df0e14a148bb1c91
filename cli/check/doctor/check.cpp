#include "cli/check/doctor/check.h"

#include <algorithm>
#include <utility>

#include "common/process/stop_signal.h"

namespace parray::doctor {

std::string_view name_of(CheckStatus status) {
  switch (status) {
    case CheckStatus::ok: return "ok";
    case CheckStatus::warning: return "warning";
    case CheckStatus::failed: return "failed";
    default: return "skipped";
  }
}

namespace {

CheckResult make_result(CheckStatus status, std::string detail, std::string remedy) {
  CheckResult result;
  result.status = status;
  result.detail = std::move(detail);
  result.remedy = std::move(remedy);
  return result;
}

}  // namespace

CheckResult passed(std::string detail) {
  return make_result(CheckStatus::ok, std::move(detail), {});
}
CheckResult warned(std::string detail, std::string remedy) {
  return make_result(CheckStatus::warning, std::move(detail), std::move(remedy));
}
CheckResult failed(std::string detail, std::string remedy) {
  return make_result(CheckStatus::failed, std::move(detail), std::move(remedy));
}
CheckResult skipped(std::string detail, std::string remedy) {
  return make_result(CheckStatus::skipped, std::move(detail), std::move(remedy));
}

CheckResult run(const Check& check) {
  CheckResult found;
  try {
    found = check.run();
  } catch (const Interrupted&) {
    throw;
  } catch (const std::exception& error) {
    found = failed(error.what(), "fix the problem in the message, then run parray doctor again");
  }
  found.name = check.name;
  return found;
}

std::size_t count_of(const std::vector<CheckResult>& results, CheckStatus status) {
  return static_cast<std::size_t>(std::ranges::count(results, status, &CheckResult::status));
}

}  // namespace parray::doctor
