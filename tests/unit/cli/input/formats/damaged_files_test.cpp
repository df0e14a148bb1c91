#include <doctest/doctest.h>

#include <string>

#include "common/base/error.h"
#include "tests/support/dice.h"
#include "tests/support/memory.h"
#include "tests/support/particle_files.h"
#include "tests/support/rooms.h"
#include "tests/support/sample_particles.h"
#include "tests/support/sample_trajectories.h"
#include "tests/support/trials.h"

namespace parray {
namespace {

using test::broken_promise;
using test::Dice;
using test::ParticleFiles;
using test::valid_particle_files;
using test::valid_simulation_files;

/// One to three mild injuries: bytes changed, cut out, doubled, moved; or the end cut off.
void damage(std::string& text, Dice& dice) {
  for (std::uint64_t n = 1 + dice.below(3); n > 0 && !text.empty(); --n) {
    const std::size_t place = dice.below(text.size());
    const std::size_t length = 1 + dice.below(12);
    constexpr std::string_view likely = "0123456789-+.eE,;:\"'# \t\n\r\0nN\xFF_";
    switch (dice.below(7)) {
      case 0: text[place] = static_cast<char>(dice.below(256)); break;
      case 1: text[place] = static_cast<char>(text[place] ^ (1 << dice.below(8))); break;
      case 2: text[place] = likely[dice.below(likely.size())]; break;
      case 3: text.erase(place, length); break;
      case 4: text.insert(place, text.substr(dice.below(text.size()), length)); break;
      case 5: text.insert(place, std::string(length, likely[dice.below(likely.size())])); break;
      default:
        if (dice.one_in(3)) text.resize(place);
    }
  }
}

/// Reads a file damaged in `rounds` ways; how many of them were read and how many refused.
std::pair<int, int> read_damaged(const std::string& name, const std::string& valid,
                                 std::uint64_t rounds) {
  const ParticleFiles files;
  int read = 0;
  int refused = 0;
  for (std::uint64_t seed = 0; seed < rounds; ++seed) {
    Dice dice(seed);
    std::string text = valid;
    damage(text, dice);
    CAPTURE(seed);
    CAPTURE(name);
    try {  // anything but an InputError fails the test
      const std::string broken = broken_promise(files.read(name, text));
      CHECK(broken == "");
      ++read;
    } catch (const InputError& error) {
      const std::string message = error.what();
      CHECK(message.find(name) != std::string::npos);
      CHECK(message.find('\n') == std::string::npos);
      CHECK(message.size() < 400);
      ++refused;
    }
  }
  return {read, refused};
}

}  // namespace

TEST_CASE("files damaged in hundreds of ways are read as valid particles or refused") {
  const std::uint64_t before = test::peak_address_space();
  for (const auto& file : valid_particle_files()) {
    const std::string& name = file.first;
    const std::string& valid = file.second;
    CAPTURE(name);
    REQUIRE(ParticleFiles().message(name, valid) == "no error");
    const auto [read, refused] = read_damaged(name, valid, test::trials(800));
    CHECK(read > 40);  // mild enough to get far into the reader
    CHECK(refused > 40);
  }
  // A count that is believed takes gigabytes; the address sanitizer keeps 256 MiB of freed memory.
  CHECK(test::peak_address_space() - before < 1'000'000'000);
}

TEST_CASE("files of simulations damaged in many ways are read as valid particles or refused") {
  const std::uint64_t before = test::peak_address_space();
  for (const auto& file : valid_simulation_files()) {
    const std::string& name = file.first;
    CAPTURE(name);
    REQUIRE(ParticleFiles().message(name, file.second) == "no error");
    const auto [read, refused] = read_damaged(name, file.second, test::trials(400));
    CHECK(read > 8);
    CHECK(refused > 8);
  }
  CHECK(test::peak_address_space() - before < 1'000'000'000);
}

TEST_CASE("packed files damaged in many ways are read or refused") {
  for (const auto& [name, valid] : valid_particle_files()) {
    const auto [read, refused] = read_damaged(name + ".gz", test::packed(valid), 300);
    CHECK(read + refused == 300);
    CHECK(refused > 200);
  }
}

TEST_CASE("every truncated file is read or refused") {
  const ParticleFiles files;
  for (const auto& file : valid_particle_files()) {
    const std::string& name = file.first;
    const std::string& valid = file.second;
    CAPTURE(name);
    for (std::size_t length = 0; length < valid.size(); ++length) {
      try {
        const std::string broken = broken_promise(files.read(name, valid.substr(0, length)));
        CHECK(broken == "");
      } catch (const InputError& error) {
        CHECK(std::string(error.what()).find(name) != std::string::npos);
      }
    }
  }
}

}  // namespace parray
