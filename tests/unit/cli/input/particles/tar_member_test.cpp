#include "cli/input/particles/tar_member.h"

#include <doctest/doctest.h>

#include <array>
#include <string>
#include <vector>

#include "cli/input/particles/packed_file.h"
#include "tests/support/particle_files.h"

namespace parray {
namespace {

using test::packed;
using test::ParticleFiles;

const std::string xyz_member = "2\n\nC 1 0 0\nO 2 0 0\n";
const std::string tar_refusal = "a: looks like a tar archive: unpack it, and name a file in it";

/// Returns a number as octal digits.
std::string octal(std::size_t number, std::size_t digits) {
  std::string text(digits, '0');
  for (; number > 0 && digits > 0; number /= 8) {
    text[--digits] = static_cast<char>('0' + number % 8);
  }
  return text;
}

/// Returns the part of an archive with the checksum of its header.
std::string with_sum(std::string part) {
  part.replace(148, 8, 8, ' ');
  std::size_t sum = 0;
  for (const char c : part.substr(0, tar_block_bytes)) sum += static_cast<unsigned char>(c);
  return part.replace(148, 6, octal(sum, 6));
}

/// Returns a part of an archive as POSIX.1-1988 describes it.
std::string part_of_tar(const std::string& name, const std::string& bytes, char type = '0') {
  std::string part = name + std::string(tar_block_bytes - name.size(), '\0');
  part.replace(124, 11, octal(bytes.size(), 11));
  part[156] = type;
  part.replace(257, 5, "ustar");
  const std::size_t blocks = (bytes.size() + tar_block_bytes - 1) / tar_block_bytes;
  return with_sum(part + bytes + std::string(blocks * tar_block_bytes - bytes.size(), '\0'));
}

const std::string tar_end(2 * tar_block_bytes, '\0');

TEST_CASE("a tar archive of one file counts as that file, whatever its compression and name") {
  const ParticleFiles files;
  const std::string tar = part_of_tar("a.xyz", xyz_member) + tar_end;
  const std::vector<std::array<std::string, 2>> packings{
      {"gzip", "tar.gz"}, {"bzip2", "tar.bz2"}, {"xz", "tar.xz"}, {"zstd", "tar.zst"}};
  const std::vector<Vec3d> positions{{1, 0, 0}, {2, 0, 0}};
  for (const std::string name : {"a.tar", "a.xyz.bz2", "noname"}) {
    const Particles particles = files.read(name, tar);
    CHECK(particles.positions == positions);
    CHECK(particles.facts.packing == "tar");
    CHECK(particles.facts.format == "XYZ");
  }
  for (const auto& row : packings) {
    const std::string& packing = row[0];  // Clang 14 does not capture a structured binding
    const std::string& of_tar = row[1];
    CAPTURE(packing);
    const Particles particles = files.read("a", packed(tar, packing));
    CHECK(particles.positions == positions);
    CHECK(particles.facts.packing == of_tar);
  }
}

TEST_CASE("folders, long names and attributes beside the only file do not matter") {
  const ParticleFiles files;
  const std::string archive =
      part_of_tar("folder/", "", '5') +
      part_of_tar("././@PaxHeader", "30 mtime=1463063120.123456789\n", 'x') +
      part_of_tar("././@LongLink", std::string(700, 'n'), 'L') +
      part_of_tar("folder/a.xyz", xyz_member) + part_of_tar("later/", "", '5');
  CHECK(files.read("a", archive + tar_end).positions.size() == 2);
  CHECK(files.read("a", archive).positions.size() == 2);  // without blocks at its end
}

TEST_CASE("the bytes of the only file are read, skipped and read again") {
  const ParticleFiles files;
  const std::string bytes(1000, '7');
  PackedFile file(files.write("a", part_of_tar("b", bytes + "89") + tar_end));
  std::string five(5, '\0');
  CHECK(file.skip(999));
  CHECK(file.read(five.data(), 5) == 3);
  CHECK(five.substr(0, 3) == "789");
  CHECK(file.read(five.data(), 5) == 0);
  CHECK(file.start().bytes() == bytes + "89");
  CHECK(file.start().whole());
  CHECK_FALSE(file.skip(1003));
}

TEST_CASE("a tar archive with several files, with a link or without a file is refused") {
  const ParticleFiles files;
  const std::string one = part_of_tar("a.xyz", xyz_member);
  for (const std::string& archive :
       {one + part_of_tar("b.xyz", xyz_member), one + part_of_tar("b", "", '2'),
        one + part_of_tar("b", "", '1'), part_of_tar("folder/", "", '5')}) {
    CHECK(files.message("a", archive + tar_end) == tar_refusal);
    CHECK(files.message("a", packed(archive + tar_end)) == tar_refusal);
  }
}

TEST_CASE("a damaged or truncated tar archive, or a size beyond its end, is refused in one line") {
  const ParticleFiles files;
  const std::string one = part_of_tar("a.xyz", xyz_member);
  std::string wrong_sum = one + tar_end;
  wrong_sum[0] = 'b';
  const auto with_size = [&](const std::string& size) {
    return with_sum(std::string(one).replace(124, size.size(), size)) + tar_end;
  };
  REQUIRE(files.message("a", with_size(octal(xyz_member.size(), 11))) == "no error");
  for (const std::string& archive :
       {wrong_sum, with_size("a number"), with_size("-0000000001"), with_size("77777777777"),
        one.substr(0, one.size() - 1), one + "rest"}) {
    CHECK(files.message("a", archive) == tar_refusal);
  }
  for (std::size_t bytes = 265; bytes < one.size(); bytes += 97) {
    CHECK(files.message("a", one.substr(0, bytes)) == tar_refusal);
  }
}

}  // namespace
}  // namespace parray
