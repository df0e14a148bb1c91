#include "cli/input/particles/particle_input.h"

#include <algorithm>
#include <cstring>
#include <string>

#include "common/base/text.h"

namespace parray::input {

ParticleInput::ParticleInput(PackedFile& file)
    : file_(&file), block_(4 * max_bytes_at_once), place_{file.name()} {}

/// Reads more bytes of the file. Enlarges a block that has no place for them.
bool ParticleInput::refill() {
  std::memmove(block_.data(), block_.data() + next_, filled_ - next_);
  filled_ -= next_;
  next_ = 0;
  if (filled_ == block_.size()) block_.resize(2 * block_.size());
  const std::size_t got = file_->read(block_.data() + filled_, block_.size() - filled_);
  filled_ += got;
  return got > 0;
}

/// Finds out from the first line whether lines end with "\r" alone.
void ParticleInput::find_line_end() {
  if (filled_ == next_) refill();
  const std::string_view text(block_.data() + next_, filled_ - next_);
  const std::size_t end = text.find_first_of("\r\n");
  if (end == std::string_view::npos || text[end] != '\r') return;
  if (end + 1 < text.size() && text[end + 1] != '\n') line_end_ = '\r';
}

bool ParticleInput::next_line() {
  place_.unit = FilePlace::Unit::line;
  place_.number = ++line_number_;
  if (line_number_ == 1) find_line_end();
  const char* end = nullptr;
  for (;;) {
    const char* start = block_.data() + next_;
    const std::size_t length = filled_ - next_;
    end = length == 0 ? nullptr : static_cast<const char*>(std::memchr(start, line_end_, length));
    if (end != nullptr) break;
    if (length > max_line_bytes) break;
    if (!refill()) break;
  }
  const char* start = block_.data() + next_;
  std::size_t length = end != nullptr ? static_cast<std::size_t>(end - start) : filled_ - next_;
  if (length > max_line_bytes) {
    fail("a line has more than " + std::to_string(max_line_bytes) +
         " bytes: check that this is a text file");
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

void ParticleInput::skip_rows(std::uint64_t count) {
  for (std::uint64_t i = 0; i < count; ++i) {
    if (!next_line()) fail_incomplete("the file ends within a frame");
  }
}

void ParticleInput::fail_within(std::uint64_t done, std::uint64_t count,
                                std::string_view what) const {
  fail_incomplete("the file ends after " + std::to_string(done) + " of " + std::to_string(count) +
                  " " + std::string(what));
}

/// Refills the block until it contains `count` unread bytes. Returns false if the file ends before.
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
  place_.unit = FilePlace::Unit::byte;
  place_.number = taken_;
  const auto held = static_cast<std::size_t>(std::min<std::uint64_t>(count, filled_ - next_));
  next_ += held;
  taken_ += count;
  return count == held || file_->skip(count - held);
}

std::optional<std::uint64_t> ParticleInput::bytes_left() const {
  const std::optional<std::uint64_t> size = file_->size();
  if (!size) return {};
  return *size - std::min(*size, taken_);
}

}  // namespace parray::input
