#pragma once

#include <cstdint>
#include <functional>
#include <nlohmann/json.hpp>
#include <string>
#include <string_view>
#include <vector>

#include "common/rooms.h"

/// The checks of `parray doctor`, and their results.
namespace parray::doctor {

enum class CheckStatus : std::uint8_t { ok, warning, failed, skipped };
/// Returns "ok", "warning", "failed" or "skipped".
std::string_view name_of(CheckStatus status);

/// The result of a check.
struct CheckResult {
  std::string name;
  CheckStatus status = CheckStatus::ok;
  std::string detail;                               ///< one line for a person
  std::string remedy;                               ///< one line; empty: nothing to do
  nlohmann::json facts = nlohmann::json::object();  ///< numbers and names for scripts
};

/// The remedy of checks that found wrong bits.
inline constexpr const char* wrong_bits =
    "use another --isa; if all are wrong, do not render on this machine, and please tell the "
    "developers of ParRay";

// Results without a name; run() sets it.
CheckResult passed(std::string detail);
CheckResult warned(std::string detail, std::string remedy);
CheckResult failed(std::string detail, std::string remedy);
CheckResult skipped(std::string detail, std::string remedy);

struct Check {
  std::string name;
  std::function<CheckResult()> run;
};

/// Runs a check and returns its result with its name. If the check throws, the result is `failed`
/// with the exception's message. Interrupted passes through.
CheckResult run(const Check& check);

/// Returns the number of results with that status.
std::size_t count_of(const std::vector<CheckResult>& results, CheckStatus status);

/// Returns the checks of `parray doctor` in their order, with those of `--extremes` (extremes.h) if
/// `extremes`. Run the checks in this order: the check "temporary directory" creates a directory in
/// which later checks write. Without the directory, these are skipped. The directory lasts until
/// all copies of the checks are destroyed.
std::vector<Check> doctor_checks(bool extremes);

}  // namespace parray::doctor
