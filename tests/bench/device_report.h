#pragma once

#include <filesystem>
#include <string>

#include "tests/bench/device_checks.h"
#include "tests/support/cuda/cuda_device.h"

namespace parray::bench {

/// Returns the figures of the device itself.
Json facts_of(const test::CudaDevice& device);

/// Returns the row of the goal; null: it was not measured.
Json goal_row(const Json& report);
/// Returns a line that says whether the goal is reached; empty: its row was not measured.
std::string goal_line(const Json& report);

/// Writes device.json and device.md to `folder`, which it makes. Throws RunError.
void write_report(const Json& report, const std::filesystem::path& folder);

}  // namespace parray::bench
