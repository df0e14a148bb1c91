#include "common/input/particles/particle_input.h"

#include <algorithm>
#include <cstring>
#include <string>

#include "common/input/particles/particle_text.h"

namespace parray {

ParticleInput::ParticleInput(PackedFile& file)
    : file_(&file), block_(4 * max_line_bytes), place_{file.name()} {}

bool ParticleInput::refill() {
  std::memmove(block_.data(), block_.data() + next_, filled_ - next_);
  filled_ -= next_;
  next_ = 0;
  const std::size_t got = file_->read(block_.data() + filled_, block_.size() - filled_);
  filled_ += got;
  return got > 0;
}

bool ParticleInput::next_line() {
  place_.unit = FilePlace::Unit::line;
  place_.number = ++line_number_;
  const char* end = nullptr;
  for (;;) {
    const char* start = block_.data() + next_;
    const std::size_t length = filled_ - next_;
    end = length == 0 ? nullptr : static_cast<const char*>(std::memchr(start, '\n', length));
    if (end != nullptr) break;
    if (length > max_line_bytes) break;
    if (!refill()) break;
  }
  const char* start = block_.data() + next_;
  std::size_t length = end != nullptr ? static_cast<std::size_t>(end - start) : filled_ - next_;
  if (length > max_line_bytes) {
    fail("a line of more than " + std::to_string(max_line_bytes) + " bytes: is this a text file?");
  }
  if (end == nullptr && length == 0) {
    place_.number = --line_number_;
    return false;
  }
  const std::size_t taken = length + (end != nullptr ? 1 : 0);
  next_ += taken;
  taken_ += taken;
  if (length > 0 && start[length - 1] == '\r') --length;
  line_ = {start, length};
  constexpr std::string_view byte_order_mark = "\xEF\xBB\xBF";
  if (line_number_ == 1 && line_.starts_with(byte_order_mark)) {
    line_.remove_prefix(byte_order_mark.size());
  }
  return true;
}

bool ParticleInput::next_filled_line() {
  while (next_line()) {
    if (!trimmed(line_).empty()) return true;
  }
  return false;
}

/// Refills until the block holds `count` bytes not taken; false when the file ends before.
bool ParticleInput::fill(std::size_t count) {
  while (filled_ - next_ < count) {
    if (!refill()) return false;
  }
  return true;
}

const char* ParticleInput::peek_bytes(std::size_t count) {
  if (count > block_.size()) block_.resize(count);
  return fill(count) ? block_.data() + next_ : nullptr;
}

bool ParticleInput::skip_bytes(std::uint64_t count) {
  while (count > 0) {
    const auto part = static_cast<std::size_t>(std::min<std::uint64_t>(count, max_bytes_at_once));
    if (next_bytes(part) == nullptr) return false;
    count -= part;
  }
  return true;
}

std::optional<std::uint64_t> ParticleInput::bytes_left() const {
  const std::optional<std::uint64_t> size = file_->size();
  if (!size) return {};
  return *size - std::min(*size, taken_);
}

void ParticleInput::fail_without_frame(std::uint64_t frames, std::uint64_t asked) const {
  fail("the file ends after " + std::to_string(frames) + (frames == 1 ? " frame" : " frames") +
       ": there is no frame " + std::to_string(asked) + ", counted from 0");
}

}  // namespace parray
