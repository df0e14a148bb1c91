#pragma once

#include <string>

#include "common/process/description.h"

/// Returns scripts with which shells complete commands, options, their values, files and job
/// numbers. Each script is a file of its own: PROGRAM, _PROGRAM, PROGRAM.fish.
namespace parray::process {

/// Functions that stand in files of their own: PROGRAM, _PROGRAM, PROGRAM.fish.
std::string bash_completion(const ProgramText& program);
std::string zsh_completion(const ProgramText& program);
std::string fish_completion(const ProgramText& program);

}  // namespace parray::process
