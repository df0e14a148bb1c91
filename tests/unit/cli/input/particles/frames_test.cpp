#include "cli/input/particles/frames.h"

#include <doctest/doctest.h>

#include <string>
#include <utility>

#include "cli/input/particles/packed_file.h"
#include "tests/support/particle_columns.h"
#include "tests/support/particle_files.h"
#include "tests/support/rooms.h"

namespace parray {
namespace {

using test::everything;
using test::last_frame;
using test::message_of;
using test::packed;
using test::ParticleFiles;

const std::string three_frames =
    "1\nfirst\nC 1 0 0\n2\nsecond\nC 2 0 0\nO 3 0 0\n\n1\nthird\nH 4 0 0\n";

ParticleRequest at(std::uint64_t frame) { return {.frame = FrameChoice{frame, false}}; }

std::string dump_frame(int step, const std::string& x) {
  return "ITEM: TIMESTEP\n" + std::to_string(step) +
         "\nITEM: NUMBER OF ATOMS\n1\nITEM: BOX BOUNDS pp pp pp\n0 8\n0 8\n0 8\n"
         "ITEM: ATOMS id x y z radius\n1 " +
         x + " 0 0 1\n";
}

std::string pdb_model(int number, const std::string& x) {
  return "MODEL        " + std::to_string(number) + "\nATOM      1  CA  ALA A   1     " + x +
         "   0.000   0.000  1.00  0.00           C\n"
         "ENDMDL\n";
}

}  // namespace

TEST_CASE("each frame of a trajectory is read by its number, from 0") {
  const ParticleFiles files;
  const auto xyz_file = files.write("a.xyz", three_frames);
  CHECK(read_particles(xyz_file).positions[0].x == 1);
  CHECK(read_particles(xyz_file, at(1)).count() == 2);
  CHECK(read_particles(xyz_file, at(1)).positions[1].x == 3);
  CHECK(read_particles(xyz_file, at(2)).positions[0].x == 4);
  CHECK(read_particles(files.write("b.xyz.gz", packed(three_frames)), at(2)).positions[0].x == 4);
  const auto dump = files.write("a.dump", dump_frame(0, "5") + dump_frame(100, "6"));
  CHECK(read_particles(dump, at(0)).positions[0].x == 5);
  CHECK(read_particles(dump, at(1)).positions[0].x == 6);
  const auto pdb =
      files.write("a.pdb", pdb_model(1, "  7.000") + pdb_model(2, "  8.000") + "END\n");
  CHECK(read_particles(pdb, at(0)).positions[0].x == 7);
  CHECK(read_particles(pdb, at(1)).positions[0].x == 8);
}

TEST_CASE("a cursor reads ascending frames without returning to the front of the file") {
  const ParticleFiles files;
  for (const auto& [name, bytes] :
       {std::pair{"a.xyz", three_frames}, {"b.xyz.gz", packed(three_frames)}}) {
    PackedFile file(files.write(name, bytes));
    FrameCursor cursor;
    const auto read = [&](std::uint64_t frame) {
      ParticleRequest request = at(frame);
      request.cursor = &cursor;
      return read_particles(file, request);
    };
    CHECK(read(0).positions[0].x == 1);
    const std::uint64_t rewinds = file.rewinds();
    CHECK(read(1).positions[1].x == 3);
    CHECK(read(2).positions[0].x == 4);
    CHECK(read(2).facts.frame == 2);
    CHECK(file.rewinds() == rewinds + 1);  // for the second time that it read frame 2
    CHECK(read(0).count() == 1);
    CHECK(read(2).positions[0].x == 4);
    CHECK(message_of<InputError>([&] { (void)read(3); }).find("no frame 3") != std::string::npos);
    CHECK(read(1).count() == 2);
    (void)read_particles(file, at(0));  // without the cursor: the file is elsewhere now
    CHECK(read(2).positions[0].x == 4);
  }
}

TEST_CASE("a missing frame is refused with the number of frames") {
  const ParticleFiles files;
  const auto message = [&](const char* name, const std::string& bytes, std::uint64_t frame) {
    return message_of<InputError>([&] { read_particles(files.write(name, bytes), at(frame)); });
  };
  const auto says = [](const std::string& text, const std::string& part) {
    return text.find(part) != std::string::npos;
  };
  CHECK(says(message("a.xyz", three_frames, 3),
             "after 3 frames: it has no frame 3 (the first frame is 0)"));
  CHECK(says(message("a.dump", dump_frame(0, "5"), 1), "after 1 frame: it has no frame 1"));
  CHECK(says(message("a.pdb", pdb_model(1, "  7.000") + "END\n", 4), "after 1 frame"));
  CHECK(says(message("a.pdb", pdb_model(1, "  7.000") + "END\n", 1), "has no frame 1"));
  CHECK(says(message("a.csv", "x,y,z,radius\n1,2,3,1\n", 1),
             "the file has no frame 1: it has one frame, number 0"));
  CHECK(says(message("a.xyz", "5\nfirst\nC 1 0 0\n", 1), "within a frame"));
}

TEST_CASE("the last frame is found without its number, and frames are counted on request") {
  const ParticleFiles files;
  for (const auto& file :
       {files.write("a.xyz", three_frames), files.write("a.xyz.gz", packed(three_frames))}) {
    const Particles particles = read_particles(file, last_frame);
    CHECK(particles.positions.at(0).x == 4);
    CHECK(particles.facts.frame == 2);
    CHECK(particles.facts.frames == 3U);
    CHECK(!read_particles(file, at(1)).facts.frames);
    CHECK(read_particles(file, everything).facts.frames == 3U);
    CHECK(read_particles(file, {.frame = FrameChoice{1, false}, .all = true}).facts.frames == 3U);
  }
  const auto table = files.write("a.csv", "x,y,z,radius\n1,2,3,1\n");
  CHECK(read_particles(table, last_frame).count() == 1);
}

TEST_CASE("half a frame at the end ends the count with a note") {
  const ParticleFiles files;
  const Particles particles =
      read_particles(files.write("a.xyz", three_frames + "7\n\nC 0 0 0\n"), everything);
  CHECK(particles.facts.frames == 3U);
  REQUIRE(particles.facts.notes.size() == 1);
  CHECK(particles.facts.notes[0].key == "unreadable_frames");
}

TEST_CASE("empty frames are skipped with a note, unless the request names one") {
  const ParticleFiles files;
  const auto file = files.write("a.xyz", "0\n\n0\n\n" + three_frames + "0\nend\n");
  const Particles particles = read_particles(file);
  CHECK(particles.positions.at(0).x == 1);
  CHECK(particles.facts.frame == 2);
  REQUIRE(particles.facts.notes.size() == 1);
  CHECK(particles.facts.notes[0].key == "empty_frames");
  CHECK(particles.facts.notes[0].count == 2);
  const auto message = [&](const ParticleRequest& request) {
    return message_of<InputError>([&] { read_particles(file, request); });
  };
  CHECK(message(at(0)).ends_with(
      "frame 0 has no particles: the next frame with particles is frame 2"));
  CHECK(message(last_frame)
            .ends_with("frame 5 has no particles, and neither has any later frame: choose an "
                       "earlier frame"));
  CHECK(files.message("b.xyz", "0\n\n") ==
        "b.xyz:2: the file has no particles: check that this is the right file");
}

}  // namespace parray
