#include "coordinator/store/state_commands.h"

#include <iostream>

#include "common/base/error.h"
#include "coordinator/store/state_tools.h"

namespace parray::store {

static int print_damage(const std::vector<std::string>& lines, const std::string& if_none) {
  for (const std::string& line : lines) std::cout << line << '\n';
  if (lines.empty()) std::cout << if_none << '\n';
  return lines.empty() ? 0 : 1;
}

int check_command(const std::string& directory) {
  return print_damage(find_damage(directory), directory + ": no damage");
}

int repair_command(const std::string& directory, double now) {
  print_damage(repair_state(directory, now), directory + ": there was no damage");
  return 0;
}

int backup_command(const std::vector<std::string>& places, double now) {
  if (places.size() != 2) {
    throw InputError(
        "--backup needs two directories: write --backup DIR TARGET. DIR has the state, and TARGET "
        "is new or empty");
  }
  return print_damage(back_up_state(places[0], places[1], now), places[1] + ": a complete copy");
}

}  // namespace parray::store
