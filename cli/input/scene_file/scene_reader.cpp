#include <algorithm>
#include <istream>
#include <streambuf>
#include <string>
#include <vector>

#include "cli/input/particles/packed_file.h"
#include "cli/input/scene_file/scene_builder.h"
#include "cli/input/scene_file/scene_file.h"
#include "common/scene/limits.h"

namespace parray::input {
namespace {

/// A file, expanded if it is packed, as a stream.
class FileBuffer : public std::streambuf {
 public:
  explicit FileBuffer(PackedFile& file) : file_(&file), block_(std::size_t{1} << 16) {}

 protected:
  int_type underflow() override {
    const std::size_t got = file_->read(block_.data(), block_.size());
    setg(block_.data(), block_.data(), block_.data() + got);
    return got == 0 ? traits_type::eof() : traits_type::to_int_type(block_[0]);
  }

  std::streamsize xsgetn(char* to, std::streamsize bytes) override {
    const std::streamsize ready = std::min<std::streamsize>(bytes, egptr() - gptr());
    std::copy_n(gptr(), ready, to);
    gbump(static_cast<int>(ready));
    return ready + static_cast<std::streamsize>(
                       file_->read(to + ready, static_cast<std::size_t>(bytes - ready)));
  }

 private:
  PackedFile* file_;
  std::vector<char> block_;
};

}  // namespace

SceneFile read_scene(std::istream& input, const std::string& name, int threads) {
  SceneBuilder builder(name);
  const std::uint64_t start_line = parse_json(input, name, builder);
  SceneFile file = builder.finish(start_line);
  file.duplicates = remove_duplicates(file.scene, threads);
  return file;
}

SceneFile read_scene_file(PackedFile& file, int threads) {
  if (file.size().value_or(0) > limits::max_scene_file_bytes) {
    FilePlace{file.name()}.fail("has " + std::to_string(*file.size()) + " bytes, more than " +
                                std::to_string(limits::max_scene_file_bytes) + ": split it");
  }
  file.rewind();
  FileBuffer buffer(file);
  std::istream input(&buffer);
  input.exceptions(std::ios::badbit);  // passes on what the file throws
  return read_scene(input, file.name(), threads);
}

SceneFile read_scene_file(const std::filesystem::path& path, int threads) {
  PackedFile file(path);
  return read_scene_file(file, threads);
}

}  // namespace parray::input
