#include "cli/input/scene_file/byte_source.h"

#include <algorithm>
#include <utility>

#include "cli/input/scene_file/json_value.h"
#include "common/scene/limits.h"

namespace parray::input {

ByteSource::ByteSource(std::istream& stream, std::string file)
    : stream_(&stream), file_(std::move(file)), block_(std::size_t{1} << 16) {}

bool ByteSource::refill() {
  if (end_was_reached_) return false;
  if (blocks_total_ - token_start_ > max_token_bytes) {
    fail_at(file_, line_, "",
            "a text or a run of blanks is longer than " + std::to_string(max_token_bytes) +
                " bytes: is this a scene?");
  }
  next_ = filled_ = 0;
  load();
  end_was_reached_ = filled_ == 0;
  return !end_was_reached_;
}

/// Fills the rest of the block.
void ByteSource::load() {
  stream_->read(block_.data() + filled_, static_cast<std::streamsize>(block_.size() - filled_));
  if (stream_->bad()) {
    fail_at(file_, line_, "", "reading failed here: check the file and its disk");
  }
  const auto got = static_cast<std::size_t>(stream_->gcount());
  filled_ += got;
  blocks_total_ += got;
  if (blocks_total_ > limits::max_scene_file_bytes) {
    fail_at(file_, line_, "",
            "the scene is larger than " + std::to_string(limits::max_scene_file_bytes) +
                " bytes: split it");
  }
}

std::string_view ByteSource::ahead(std::size_t least) {
  if (filled_ - next_ < least && !end_was_reached_) {
    std::copy(block_.begin() + static_cast<std::ptrdiff_t>(next_),
              block_.begin() + static_cast<std::ptrdiff_t>(filled_), block_.begin());
    filled_ -= next_;
    next_ = 0;
    load();
  }
  return std::string_view(block_.data(), filled_).substr(next_);
}

void ByteSource::fail_zero_byte() const {
  fail_at(file_, line_, "", "a NUL byte, which JSON text never has: save the file as UTF-8");
}

}  // namespace parray::input
