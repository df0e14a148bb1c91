#include <fstream>
#include <sstream>

#include "cli/output/picture/image_file.h"
#include "common/base/error.h"
#include "tests/fuzz/target.h"
#include "tests/support/rooms.h"
#include "tests/support/temporary_directory.h"

namespace parray::fuzz {
namespace {

namespace fs = std::filesystem;

std::string text_of(const fs::path& path) {
  std::ostringstream text;
  text << std::ifstream(path, std::ios::binary).rdbuf();
  return text.str();
}

void promise_whole(const ImageFile& file) {
  const std::size_t pixels = std::size_t{file.image.width} * file.image.height;
  promise(pixels > 0 && file.image.rgb.size() == 3 * pixels, "three values a pixel");
  for (const Channel& channel : file.channels) {
    const auto size = std::visit([](const auto& values) { return values.size(); }, channel.values);
    promise(size == pixels && file.high_dynamic_range, "a value a pixel in each channel");
  }
}

bool run(std::string_view input) {
  static const test::TemporaryDirectory directory;
  const fs::path path = directory.path() / "picture";
  std::ofstream(path, std::ios::binary) << input;
  try {
    promise_whole(read_image(path));
  } catch (const InputError& error) {
    promise_one_line(error.what());
    promise(std::string_view(error.what()).starts_with(path.string()), "an error with its file");
    return false;
  }
  return true;
}

std::string written(const std::string& name, const Channels& channels) {
  const test::TemporaryDirectory directory;
  Image image{5, 3, std::vector<float>(45)};
  for (std::size_t i = 0; i < image.rgb.size(); ++i) image.rgb[i] = static_cast<float>(i) / 45;
  const fs::path path = directory.path() / name;
  write_image(path, image, {{"parray:scene", "glass"}, {"DateTime", "2026:01:01 00:00:00"}},
              channels);
  return text_of(path);
}

std::vector<std::string> seeds() {
  const Channels channels{{"Z", std::vector<float>(15, 2.5F)},
                          {"sphere", std::vector<std::uint32_t>(15, 7)}};
  return {written("a.png", {}), written("a.exr", {}), written("b.exr", channels)};
}

}  // namespace

const Target picture_target{"picture", run, seeds};

}  // namespace parray::fuzz
