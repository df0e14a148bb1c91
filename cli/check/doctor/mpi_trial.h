#pragma once

#include <filesystem>
#include <optional>
#include <string>

#include "cli/check/doctor/check.h"
#include "proto/clock.h"

/// A picture that two ranks of one mpirun render.
namespace parray::doctor {

/// The directory that this program lies in; empty if the system does not say.
std::filesystem::path program_directory();

struct MpiTrial {
  std::optional<std::filesystem::path> mpirun;
  std::filesystem::path parray_mpi;
  std::filesystem::path directory;  ///< for the scene, the picture and what they print
  std::string image_sha256;         ///< of the picture as it has to be
  Time limit = seconds(30);
};

/// Renders doctor_scene() with two ranks. Without mpirun or parray-mpi: skipped.
Finding check_mpi_trial(const MpiTrial& trial);

}  // namespace parray::doctor
