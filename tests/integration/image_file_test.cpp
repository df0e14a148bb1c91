#include "cli/output/picture/image_file.h"

#include <doctest/doctest.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <csignal>
#include <cstring>
#include <fstream>
#include <limits>
#include <random>
#include <stdexcept>

#include "cli/output/picture/partial_file.h"
#include "cli/output/picture/transparency.h"
#include "common/base/error.h"
#include "tests/support/contains.h"
#include "tests/support/message_of.h"
#include "tests/support/rooms.h"
#include "tests/support/temporary_directory.h"

namespace parray {
namespace {

namespace fs = std::filesystem;
using test::contains;
using test::message_of;
using test::TemporaryDirectory;

/// Simulates a full disk: while the object exists, no file of this process may exceed `bytes`.
class FullDisk {
 public:
  explicit FullDisk(rlim_t bytes) {
    const bool ignored = std::signal(SIGXFSZ, SIG_IGN) != SIG_ERR;
    REQUIRE(ignored);
    REQUIRE(getrlimit(RLIMIT_FSIZE, &before_) == 0);
    const rlimit small{bytes, before_.rlim_max};
    REQUIRE(setrlimit(RLIMIT_FSIZE, &small) == 0);
  }
  ~FullDisk() { setrlimit(RLIMIT_FSIZE, &before_); }
  FullDisk& operator=(FullDisk&&) = delete;

 private:
  rlimit before_{};
};

Image random_image(std::uint32_t width, std::uint32_t height) {
  std::mt19937 random(1);
  std::uniform_real_distribution<float> value(0, 2);
  Image image{width, height, std::vector<float>(std::size_t{width} * height * 3)};
  for (float& v : image.rgb) v = value(random);
  return image;
}

Image grey_row(const std::vector<float>& values) {
  Image image{static_cast<std::uint32_t>(values.size()), 1, {}};
  for (const float v : values) image.rgb.insert(image.rgb.end(), {v, v, v});
  return image;
}

std::string read_text(const fs::path& path) {
  std::ifstream in(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), {}};
}

/// The byte that a PNG shows for a linear value, from what read_image() undoes.
int byte_of(float linear) {
  const TemporaryDirectory directory;
  write_image(directory.path() / "a.png", grey_row({linear}), {});
  const float decoded = read_image(directory.path() / "a.png").image.rgb.at(0);
  for (int b = 0; b < 256; ++b) {
    const double encoded = b / 255.0;
    const double value =
        encoded <= 0.04045 ? encoded / 12.92 : std::pow((encoded + 0.055) / 1.055, 2.4);
    if (static_cast<float>(value) == decoded) return b;
  }
  return -1;
}

}  // namespace

TEST_CASE("an EXR file contains the exact floats, also special ones") {
  const TemporaryDirectory directory;
  Image image = random_image(67, 301);  // more than one strip of blocks, and no multiple of 16
  image.rgb[0] = std::numeric_limits<float>::quiet_NaN();
  image.rgb[1] = std::numeric_limits<float>::infinity();
  image.rgb[2] = -0.0F;
  image.rgb[3] = std::numeric_limits<float>::denorm_min();
  image.rgb[4] = 1e30F;
  write_image(directory.path() / "a.EXR", image, {});
  const Image back = read_image(directory.path() / "a.EXR").image;
  REQUIRE(back.width == image.width);
  REQUIRE(back.height == image.height);
  CHECK(std::memcmp(back.rgb.data(), image.rgb.data(), image.rgb.size() * sizeof(float)) == 0);
  CHECK(image_sha256(back) == image_sha256(image));
}

TEST_CASE("an EXR file holds extra channels of both types beside the same RGB") {
  const TemporaryDirectory directory;
  const Image image = random_image(67, 301);
  const std::size_t pixels = std::size_t{67} * 301;
  std::vector<float> reals(pixels);
  std::vector<std::uint32_t> wholes(pixels);
  for (std::uint32_t i = 0; i < pixels; ++i) {
    reals[i] = 0.1F * static_cast<float>(i) - 500;
    wholes[i] = 0x01000001 + i * 0x9E3779B9;  // most need more than a float's 24 bits
  }
  reals[1] = std::numeric_limits<float>::infinity();
  reals[2] = -0.0F;
  wholes[3] = 0xFFFFFFFF;
  const Channels channels = {
      {"N.Y", reals}, {"albedo.R", std::vector<float>(pixels, 0.5F)}, {"sphere", wholes}};
  const fs::path path = directory.path() / "a.exr";
  write_image(path, image, {{"parray:a", "b"}}, {channels[2], channels[0], channels[1]});
  const ImageFile back = read_image(path);
  CHECK(image_sha256(back.image) == image_sha256(image));
  CHECK_UNARY(back.channels == channels);
  write_image(path, image, {});
  CHECK(read_image(path).channels.empty());
}

TEST_CASE("channels that do not fit the picture or the file are a std::logic_error") {
  const TemporaryDirectory directory;
  const Channel few{"Z", std::vector<float>(5)};
  const Channel fit{"Z", std::vector<float>(6)};
  CHECK_THROWS_AS(write_image(directory.path() / "a.exr", random_image(3, 2), {}, {few}),
                  std::logic_error);
  CHECK_THROWS_AS(write_image(directory.path() / "a.png", random_image(3, 2), {}, {fit}),
                  std::logic_error);
  CHECK(directory.files() == 0);
  CHECK(can_hold_channels("a.EXR"));
  CHECK_FALSE(can_hold_channels("a.png"));
}

TEST_CASE("a picture of one pixel, one row and one column can be written and read") {
  const TemporaryDirectory directory;
  for (const auto& [width, height] : {std::pair{1U, 1U}, {500U, 1U}, {1U, 500U}}) {
    for (const char* name : {"a.exr", "a.png"}) {
      write_image(directory.path() / name, random_image(width, height), {});
      const Image back = read_image(directory.path() / name).image;
      CHECK(back.width == width);
      CHECK(back.height == height);
    }
  }
}

TEST_CASE("a PNG file has the sRGB curve, rounded, clamped, and black for NaN") {
  // Encoded by hand: 255 * (1.055 * v^(1/2.4) - 0.055), or 255 * 12.92 * v below 0.0031308.
  CHECK(byte_of(0.0F) == 0);
  CHECK(byte_of(0.0001F) == 0);     // 0.33
  CHECK(byte_of(0.0002F) == 1);     // 0.66
  CHECK(byte_of(0.003F) == 10);     // 9.88
  CHECK(byte_of(0.18F) == 118);     // 117.67
  CHECK(byte_of(0.21403F) == 127);  // 127.5 is at 0.2140411
  CHECK(byte_of(0.21405F) == 128);
  CHECK(byte_of(0.5F) == 188);  // 187.52
  CHECK(byte_of(1.0F) == 255);
  CHECK(byte_of(7.0F) == 255);
  CHECK(byte_of(std::numeric_limits<float>::infinity()) == 255);
  CHECK(byte_of(-1.0F) == 0);
  CHECK(byte_of(-std::numeric_limits<float>::infinity()) == 0);
  CHECK(byte_of(std::numeric_limits<float>::quiet_NaN()) == 0);
}

TEST_CASE("every 8-bit value survives being read and written") {
  const TemporaryDirectory directory;
  std::vector<float> values;
  for (int b = 0; b < 256; ++b) {
    const double encoded = b / 255.0;
    values.push_back(static_cast<float>(
        encoded <= 0.04045 ? encoded / 12.92 : std::pow((encoded + 0.055) / 1.055, 2.4)));
  }
  write_image(directory.path() / "a.png", grey_row(values), {});
  const Image once = read_image(directory.path() / "a.png").image;
  CHECK(once.rgb == grey_row(values).rgb);
}

TEST_CASE("TIFF files hold the bytes that PNG files hold, alpha and metadata included") {
  const TemporaryDirectory directory;
  const Image image = random_image(7, 5);
  const Channels alpha = {{alpha_channel, std::vector<float>(35, 0.5F)}};
  for (const Channels& channels : {Channels(), alpha}) {
    for (const char* name : {"a.png", "a.tif", "b.TIFF"}) {
      write_image(directory.path() / name, image, {{"parray:width", std::uint64_t{7}}}, channels);
    }
    const ImageFile png = read_image(directory.path() / "a.png");
    for (const char* name : {"a.tif", "b.TIFF"}) {
      const ImageFile tiff = read_image(directory.path() / name);
      CHECK(tiff.image.rgb == png.image.rgb);
      CHECK(tiff.channels == png.channels);
      CHECK_FALSE(tiff.high_dynamic_range);
      CHECK(whole_in(tiff.metadata, "parray:width") == 7);
    }
  }
}

TEST_CASE("JPEG and JPEG 2000 files are near the picture; JPEG has no room for alpha") {
  const TemporaryDirectory directory;
  Image image = random_image(64, 48);
  for (std::size_t i = 0; i < image.rgb.size(); ++i) {  // smooth, as these kinds expect
    image.rgb[i] = static_cast<float>(i) / static_cast<float>(image.rgb.size());
  }
  for (const char* name : {"a.jpg", "a.jpeg", "a.jp2"}) {
    CAPTURE(name);
    write_image(directory.path() / name, image, {});
    const ImageFile read = read_image(directory.path() / name);
    REQUIRE(read.image.rgb.size() == image.rgb.size());
    float furthest = 0;
    for (std::size_t i = 0; i < image.rgb.size(); ++i) {
      furthest = std::max(furthest, std::abs(read.image.rgb[i] - image.rgb[i]));
    }
    CHECK(furthest < 0.05F);
  }
  write_image(directory.path() / "small.jp2", random_image(32, 32), {});
  CHECK(read_image(directory.path() / "small.jp2").image.rgb.size() == std::size_t{3} * 32 * 32);
  CHECK_THROWS_WITH_AS(write_image(directory.path() / "smaller.jp2", random_image(40, 31), {}),
                       doctest::Contains("at least 32 pixels"), InputError);
  CHECK(can_hold_alpha("a.jp2"));
  CHECK_FALSE(can_hold_alpha("a.jpg"));
  const Channels alpha = {{alpha_channel, std::vector<float>(64 * 48, 0.5F)}};
  CHECK_THROWS_AS(write_image(directory.path() / "b.jpg", image, {}, alpha), std::logic_error);
}

TEST_CASE("metadata are kept in both kinds of file") {
  const TemporaryDirectory directory;
  const ImageMetadata metadata = {{"Software", "ParRay test"},
                                  {"parray:image_sha256", std::string(64, 'a')},
                                  {"parray:width", std::uint64_t{3}},
                                  {"parray:samples", std::uint64_t{1} << 40},
                                  {"parray:seed", std::numeric_limits<std::uint64_t>::max()},
                                  {"parray:error:rmse", 0.1}};
  for (const char* name : {"a.exr", "a.png"}) {
    write_image(directory.path() / name, random_image(3, 2), metadata);
    const ImageMetadata read = read_image(directory.path() / name).metadata;
    for (const auto& pair : as_kept(metadata, name[2] == 'e')) {
      CHECK_MESSAGE(std::find(read.begin(), read.end(), pair) != read.end(), name, " ", pair.first);
    }
    CHECK(whole_in(read, "parray:width") == 3);
    CHECK(whole_in(read, "parray:samples") == std::uint64_t{1} << 40);
    CHECK(whole_in(read, "parray:seed") == std::numeric_limits<std::uint64_t>::max());
    CHECK(real_in(read, "parray:error:rmse") == 0.1);
  }
}

TEST_CASE("an EXR file says which colours its values are, a PNG file how to show them") {
  const TemporaryDirectory directory;
  write_image(directory.path() / "a.exr", random_image(3, 2), {});
  // The attribute's name, its type, its size, and Rec. 709's red x as a float.
  const std::string red =
      std::string("chromaticities\0chromaticities\0\x20\0\0\0\x0a\xd7\x23\x3f", 38);
  CHECK(contains(read_text(directory.path() / "a.exr"), red));
  write_image(directory.path() / "a.png", random_image(3, 2), {});
  // Intent 0, perceptual, and the chunk's checksum.
  const std::string intent = std::string("\0\0\0\1sRGB\0\xAE\xCE\x1C\xE9", 13);
  CHECK(contains(read_text(directory.path() / "a.png"), intent));
}

TEST_CASE("an unknown extension, a directory and a place that cannot be written to are refused") {
  const TemporaryDirectory directory;
  const auto refusal = [&](const std::string& name) {
    return message_of<InputError>([&] { check_image_path(directory.path() / name); });
  };
  CHECK(refusal("a.exr") == "no error");
  CHECK(refusal("a.PNG") == "no error");
  CHECK(refusal("a.Tif") == "no error");
  CHECK(refusal("a.jpg") == "no error");
  CHECK(contains(refusal("a.gif"), "'.gif'"));
  CHECK(contains(refusal("a.gif"), ".exr"));
  CHECK(contains(refusal("a"), ".png"));
  CHECK(contains(refusal(".png"), "no extension"));
  CHECK(contains(refusal("none/a.png"), "does not exist"));
  CHECK(contains(refusal(std::string(300, 'a') + ".png"), "too long"));
  fs::create_directory(directory.path() / "d.png");
  CHECK(contains(refusal("d.png"), "is a directory"));
  CHECK(contains(refusal(""), "is a directory"));
  REQUIRE(mkfifo((directory.path() / "f.png").c_str(), 0600) == 0);
  CHECK(contains(refusal("f.png"), "not a regular file"));
  CHECK(directory.files() == 2);
}

TEST_CASE("a full disk is an error, leaves no partial file, and keeps the older picture") {
  const TemporaryDirectory directory;
  for (const char* name : {"a.exr", "a.png"}) {
    const fs::path path = directory.path() / name;
    write_image(path, random_image(4, 4), {});
    const std::string before = read_text(path);
    for (const rlim_t bytes : {0U, 100U, 5000U}) {
      const FullDisk full(bytes);
      const std::string message =
          message_of<RunError>([&] { write_image(path, random_image(200, 200), {}); });
      CHECK_MESSAGE(contains(message, "writing " + path.string() + ": File too large"), message);
      CHECK_FALSE(contains(message, "\n"));
    }
    CHECK(read_text(path) == before);
    CHECK(directory.files() == 1);
    fs::remove(path);
  }
}

TEST_CASE("an exception between two strips ends the writing and leaves no file") {
  const TemporaryDirectory directory;
  for (const char* name : {"a.exr", "a.png"}) {
    int calls = 0;
    CHECK_THROWS_AS(write_image(directory.path() / name, random_image(1000, 1000), {}, {},
                                [&] {
                                  if (++calls == 3) throw std::logic_error("enough");
                                }),
                    std::logic_error);
    CHECK(directory.files() == 0);
  }
}

TEST_CASE("a text file is written whole or not at all") {
  const TemporaryDirectory directory;
  const fs::path path = directory.path() / "r.json";
  write_text_file(path, "first");
  CHECK(read_text(path) == "first");
  {
    const FullDisk full(10);
    const std::string message =
        message_of<RunError>([&] { write_text_file(path, std::string(100, 'x')); });
    CHECK(contains(message, "writing " + path.string() + ": File too large"));
  }
  CHECK(read_text(path) == "first");
  CHECK(directory.files() == 1);
}

TEST_CASE("a file that is not a picture is refused with its name") {
  const TemporaryDirectory directory;
  for (const char* name : {"a.exr", "a.png", "none.png"}) {
    const fs::path path = directory.path() / name;
    if (name[0] == 'a') std::ofstream(path) << "this is text";
    CHECK(contains(message_of<InputError>([&] { read_image(path); }), path.string() + ": "));
  }
}

TEST_CASE("the content of a file determines its format, not its name") {
  const TemporaryDirectory directory;
  const fs::path path = directory.path() / "a.exr";
  write_image(directory.path() / "a.png", grey_row({0.5F}), {});
  fs::rename(directory.path() / "a.png", path);
  const ImageFile png = read_image(path);
  CHECK_FALSE(png.high_dynamic_range);
  CHECK(png.image.rgb.at(0) == doctest::Approx(0.5).epsilon(0.01));  // the sRGB curve undone
  write_image(path, grey_row({0.5F}), {});
  CHECK(read_image(path).high_dynamic_range);
  std::ofstream(directory.path() / "a.ppm") << "P6 1 1 255\n\xff" << std::string(1, '\0') << "\xbc";
  const ImageFile other = read_image(directory.path() / "a.ppm");
  CHECK_FALSE(other.high_dynamic_range);
  CHECK(other.image.rgb.at(0) == 1);
  CHECK(other.image.rgb.at(1) == 0);
  CHECK(other.image.rgb.at(2) == doctest::Approx(0.5).epsilon(0.01));
}

TEST_CASE("a PNG file that is truncated or changed at any place is refused") {
  const TemporaryDirectory directory;
  const fs::path path = directory.path() / "a.png";
  write_image(path, random_image(4, 3), {});
  const std::string whole = read_text(path);
  const auto refusal_of = [&](const std::string& bytes) {
    std::ofstream(path, std::ios::binary) << bytes;
    return message_of<InputError>([&] { read_image(path); });
  };
  constexpr std::size_t signature = 8;
  for (std::size_t place = signature; place < whole.size(); ++place) {
    CAPTURE(place);
    CHECK(contains(refusal_of(whole.substr(0, place)), "a.png: the PNG file is truncated"));
    std::string changed = whole;
    changed[place] = static_cast<char>(changed[place] ^ 4);
    CHECK(contains(refusal_of(changed), "a.png: the PNG file is "));
  }
  CHECK(refusal_of(whole) == "no error");
}

TEST_CASE("a picture with a side beyond the limit is refused before its pixels are read") {
  const TemporaryDirectory directory;
  const fs::path path = directory.path() / "wide.png";
  write_image(path, grey_row(std::vector<float>(65537, 0)), {});
  CHECK(contains(
      message_of<InputError>([&] { read_image(path); }),
      "wide.png: 65537 x 1 pixels are too many: use at most 65536 per side and 67108864 in total"));
}

TEST_CASE(
    "more channels than the largest picture of ours has are refused before they take memory") {
  const TemporaryDirectory directory;
  const fs::path path = directory.path() / "deep.exr";
  Channels channels;
  for (int i = 0; i < 14; ++i) channels.push_back({"c" + std::to_string(i), std::vector<float>(1)});
  write_image(path, grey_row({0.5F}), {}, channels);
  std::string bytes = read_text(path);
  for (const char* window : {"dataWindow", "displayWindow"}) {
    const std::string key = window + std::string("\0box2i\0\x10\0\0\0", 11);
    const std::size_t corner = bytes.find(key) + key.size() + 8;
    bytes.replace(corner, 8, "\xff\x1f\0\0\xff\x1f\0\0", 8);  // 8192 x 8192 pixels
  }
  std::ofstream(path, std::ios::binary) << bytes << std::string(10'000, '\0');  // a table of places
  CHECK(contains(message_of<InputError>([&] { read_image(path); }),
                 "deep.exr: 17 channels have more than 4294967296 bytes: remove some"));
}

TEST_CASE("damaged files of other kinds are refused in one line") {
  const TemporaryDirectory directory;
  for (const char* bytes :
       {"II*", "8BPS", "GIF89a", "BM", "\xff\xd8\xff\xe0", "\x89PNG\r\n\x1a", ""}) {
    const fs::path path = directory.path() / "a.png";
    std::ofstream(path, std::ios::binary) << bytes;
    const std::string refusal = message_of<InputError>([&] { read_image(path); });
    CAPTURE(refusal);
    CHECK((refusal.starts_with(path.string() + ": not a picture in a known format") ||
           refusal.starts_with(path.string() + ": the picture cannot be read: ")));
    CHECK_FALSE(contains(refusal, "\n"));
  }
}

}  // namespace parray
