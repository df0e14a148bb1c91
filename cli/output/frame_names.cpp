#include "cli/output/frame_names.h"

#include <algorithm>
#include <charconv>

#include "common/base/error.h"
#include "common/base/printable.h"
#include "common/scene/limits.h"

namespace parray::output {
namespace {

/// Takes a number from the front of `text`. Returns false if there is none.
bool take_number(std::string_view& text, std::uint32_t& number) {
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number);
  text.remove_prefix(static_cast<std::size_t>(end - text.data()));
  return error == std::errc() && number <= limits::max_frame;
}

bool take(std::string_view& text, char sign) {
  const bool there = text.starts_with(sign);
  text.remove_prefix(there ? 1 : 0);
  return there;
}

/// Returns the range "FRAME", "FIRST-LAST" or "FIRST-LAST:STEP", where `between` is the first sign.
/// Returns nothing for other texts, also for "FRAME:STEP": in a film, 0:2 is FIRST:LAST. Throws
/// InputError for too many frames.
std::optional<FrameRange> range_in(std::string_view text, char between) {
  FrameRange range;
  bool good = take_number(text, range.first);
  range.last = range.first;
  const bool several = good && take(text, between);
  if (several) good = take_number(text, range.last);
  if (good && several && take(text, ':')) good = take_number(text, range.step);
  if (!good || !text.empty() || range.last < range.first || range.step == 0) return std::nullopt;
  if (range.count() > limits::max_frames) {
    throw InputError(std::to_string(range.count()) + " frames are more than the limit of " +
                     std::to_string(limits::max_frames) +
                     ": choose fewer frames, or a larger step");
  }
  return range;
}

}  // namespace

FrameRange frame_range_from(std::string_view text) {
  if (const auto range = range_in(text, '-')) return *range;
  throw InputError("'" + printable(text) +
                   "' is not a range of frames: write FRAME, FIRST-LAST or FIRST-LAST:STEP with "
                   "numbers up to " +
                   std::to_string(limits::max_frame));
}

ChosenFrames chosen_frames_from(const std::string& text) {
  if (text == "all") return {};
  if (const auto range = range_in(text, ':')) return {range};
  throw InputError("'" + printable(text) +
                   "' is not a range of frames: use \"all\", \"7\", \"0:100\" (the frames 0 to "
                   "100) or \"0:100:5\" (every fifth of them)");
}

bool has_frame_number(const std::string& name) { return name.find('#') != std::string::npos; }

std::string with_frame_number(const std::string& name, std::uint32_t frame) {
  const std::string digits = std::to_string(frame);
  std::string numbered;
  for (std::size_t i = 0; i < name.size();) {
    const std::size_t end = std::min(name.find_first_not_of('#', i), name.size());
    if (end == i) {
      numbered += name[i++];
      continue;
    }
    numbered.append(end - i > digits.size() ? end - i - digits.size() : 0, '0');
    numbered += digits;
    i = end;
  }
  return numbered;
}

}  // namespace parray::output
