// fuzz_seeds DIRECTORY: writes the seeds of every target to DIRECTORY/TARGET/seed-NUMBER.
#include <exception>
#include <filesystem>
#include <fstream>
#include <iostream>

#include "tests/fuzz/target.h"
#include "tests/support/rooms.h"

namespace {

void write_seeds(const parray::fuzz::Target& target, const std::filesystem::path& directory) {
  std::filesystem::create_directories(directory);
  std::size_t number = 0;
  for (const std::string& seed : target.seeds()) {
    std::ofstream out(directory / ("seed-" + std::to_string(number++)), std::ios::binary);
    out.exceptions(std::ios::badbit | std::ios::failbit);
    out << seed;
  }
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 2) {
    std::cerr << "usage: fuzz_seeds DIRECTORY\n";
    return 2;
  }
  try {
    for (const parray::fuzz::Target* target : parray::fuzz::targets()) {
      write_seeds(*target, std::filesystem::path(argv[1]) / target->name);
    }
  } catch (const std::exception& error) {
    std::cerr << "fuzz_seeds: " << error.what() << "\n";
    return 1;
  }
}
