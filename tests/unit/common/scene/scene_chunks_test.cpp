#include "common/scene/scene_chunks.h"

#include <doctest/doctest.h>

#include <string>

#include "common/base/bytes.h"
#include "common/scene/scene_bytes.h"
#include "tests/support/dice.h"
#include "tests/support/rooms.h"
#include "tests/support/sample_scenes.h"

namespace parray {
namespace {

/// A scene of many like spheres.
std::string orderly_bytes() {
  Scene scene = test::small_scene();
  for (int i = 0; i < 5000; ++i) {
    Sphere sphere = scene.spheres.front();
    sphere.center.x = i;
    scene.spheres.push_back(sphere);
  }
  return scene_to_bytes(scene);
}

std::string unpacked(const std::string& packed, std::size_t size) {
  std::string chunk(size, '\0');
  unpack_chunk(packed, chunk);
  return chunk;
}

}  // namespace

TEST_CASE("chunks cover a scene's bytes, each once, whatever their sizes") {
  for (const std::uint64_t bytes : {1U, 255U, 256U, 257U, 1000U, 1024U}) {
    const ChunkCut cut{bytes, 256};
    std::uint64_t end = 0;
    for (std::uint32_t i = 0; i < cut.count(); ++i) {
      CHECK(cut.begin(i) == end);
      CHECK(cut.size(i) > 0);
      end += cut.size(i);
    }
    CHECK(end == bytes);
  }
}

TEST_CASE("a chunk that is packed comes out as it was, wherever in a sphere it begins and ends") {
  const std::string bytes = orderly_bytes();
  for (const std::size_t begin : {0U, 1U, 17U, 500U}) {
    for (const std::size_t size : {100U, 36U * 100U, 36U * 100U + 35U, 70000U}) {
      const std::string chunk = bytes.substr(begin, size);
      const std::string packed = pack_chunk(chunk);
      REQUIRE(!packed.empty());
      CHECK(packed.size() < chunk.size());
      CHECK(unpacked(packed, chunk.size()) == chunk);
    }
  }
}

TEST_CASE("a chunk of noise is left as it is") {
  test::Dice dice(1);
  std::string noise(10000, '\0');
  for (char& c : noise) c = static_cast<char>(dice.below(256));
  CHECK(pack_chunk(noise).empty());
  CHECK(pack_chunk("x").empty());
}

TEST_CASE(
    "a packed chunk of another size, cut short or damaged, is refused or wrong, never worse") {
  const std::string chunk = orderly_bytes().substr(0, 3000);
  const std::string packed = pack_chunk(chunk);
  CHECK_THROWS_AS(unpacked(packed, chunk.size() + 1), DecodeError);
  CHECK_THROWS_AS(unpacked(packed, chunk.size() - 1), DecodeError);
  CHECK_THROWS_AS(unpacked("", chunk.size()), DecodeError);
  for (std::size_t size = 0; size < packed.size(); ++size) {
    CHECK_THROWS_AS(unpacked(packed.substr(0, size), chunk.size()), DecodeError);
  }
  std::size_t unnoticed = 0;  // bits that zstd does not look at
  for (std::size_t i = 0; i < packed.size(); ++i) {
    std::string damaged = packed;
    damaged[i] = static_cast<char>(damaged[i] ^ 0x41);
    bool noticed = false;
    try {
      noticed = unpacked(damaged, chunk.size()) != chunk;
    } catch (const DecodeError&) {
      noticed = true;
    }
    unnoticed += noticed ? 0 : 1;
  }
  CHECK(unnoticed <= packed.size() / 10);
}

}  // namespace parray
