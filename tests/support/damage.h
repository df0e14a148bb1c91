#pragma once

#include <filesystem>
#include <fstream>
#include <random>
#include <string>
#include <vector>

#include "tests/support/rooms.h"
#include "tests/support/stored_state.h"

namespace parray::test {

/// Damages the files of a state as disks, copies and people do: changes bytes, cuts files, removes
/// bytes from their middle, removes files.
class Damage {
 public:
  Damage(std::filesystem::path directory, std::uint64_t seed)
      : directory_(std::move(directory)), random_(seed) {}

  /// Damages one random file. Returns the damage and the file in words.
  std::string strike() {
    std::vector<std::string> names;
    for (const auto& [name, size] : files_below(directory_)) names.push_back(name);
    const std::string& name = names[roll(names.size())];
    return name + ": " + strike(directory_ / name);
  }

 private:
  std::size_t roll(std::size_t sides) { return random_() % sides; }

  std::string strike(const std::filesystem::path& file) {
    std::string bytes = file_bytes(file);
    const std::size_t kind = bytes.empty() ? 3 : roll(4);
    if (kind == 3) {
      std::filesystem::remove(file);
      return "gone";
    }
    const std::size_t at = roll(bytes.size());
    std::string what;
    if (kind == 0) {
      bytes[at] = static_cast<char>(bytes[at] ^ (1 << roll(8)));
      what = "a bit flipped at ";
    } else if (kind == 1) {
      bytes.resize(at);
      what = "cut at ";
    } else {
      bytes.erase(at, 1 + roll(1000));
      what = "bytes missing from ";
    }
    write_bytes(file, bytes);
    return what + std::to_string(at);
  }

  std::filesystem::path directory_;
  std::mt19937_64 random_;
};

}  // namespace parray::test
