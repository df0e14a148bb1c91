#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <utility>
#include <vector>

#include "cli/input/scene_file/scene_file.h"

/// What `parray validate` says of a file of particles.
namespace parray::commands {

/// As JSON: cli/REFERENCE.md lists the keys. `particles` are those of the file, with all their
/// columns.
nlohmann::json particle_report(const ParticleFile& file, const Particles& particles);

/// The same as lines for people: what, and what of it.
std::vector<std::pair<std::string, std::string>> particle_lines(const nlohmann::json& report);

/// "12 elements guessed from names".
std::string note_line(const nlohmann::json& note);

/// In one line.
std::string particle_line(const nlohmann::json& report);

}  // namespace parray::commands
