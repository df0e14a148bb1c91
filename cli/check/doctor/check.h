#pragma once

#include <cstdint>
#include <functional>
#include <nlohmann/json.hpp>
#include <string>
#include <string_view>
#include <vector>

#include "common/rooms.h"

/// What `parray doctor` looks at, one thing after the other.
namespace parray::doctor {

enum class CheckStatus : std::uint8_t { ok, warning, failed, skipped };
std::string_view name_of(CheckStatus status);

/// What a check has found.
struct Finding {
  std::string name;
  CheckStatus status = CheckStatus::ok;
  std::string detail;                               ///< one line for a person
  std::string remedy;                               ///< one line; empty where nothing is to be done
  nlohmann::json facts = nlohmann::json::object();  ///< numbers and names for scripts
};

// Findings without a name, which run() gives them.
Finding passed(std::string detail);
Finding warned(std::string detail, std::string remedy);
Finding failed(std::string detail, std::string remedy);
Finding skipped(std::string detail, std::string remedy);

struct Check {
  std::string name;
  std::function<Finding()> run;
};

/// The finding of a check, under its name; an exception is a failure, but for Interrupted, which
/// passes through.
Finding run(const Check& check);

/// How many findings have that status.
std::size_t count_of(const std::vector<Finding>& findings, CheckStatus status);

}  // namespace parray::doctor
