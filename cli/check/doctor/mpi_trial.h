#pragma once

#include <filesystem>
#include <optional>
#include <string>

#include "cli/check/doctor/check.h"
#include "proto/clock.h"

/// Renders a picture with two ranks of one mpirun.
namespace parray::doctor {

/// Returns the directory of the running program's file; empty if unknown.
std::filesystem::path program_directory();

struct MpiTrial {
  std::optional<std::filesystem::path> mpirun;  ///< nothing: there is none in PATH
  std::filesystem::path parray_mpi;             ///< the program; it may be missing
  std::filesystem::path directory;              ///< for scene, picture, report and log; must exist
  std::string image_sha256;                     ///< of the correct pixels, 64 hexadecimal digits
  Time limit = seconds(30);                     ///< longest duration of mpirun
};

/// Renders doctor_scene() with two ranks. Skipped without mpirun or parray-mpi. Fails if mpirun
/// fails or takes longer than the limit, if the picture differs, or if the number of ranks is not
/// 2. Warns if the ranks exchanged results by messages instead of an MPI window (one-sided
/// communication).
CheckResult check_mpi_trial(const MpiTrial& trial);

}  // namespace parray::doctor
