#include "cli/input/particles/frames.h"

#include <optional>
#include <string>

#include "common/base/error.h"

namespace parray::input {
namespace {

/// Skips at most `most` frames. Returns the number of skipped frames.
std::uint64_t skip_frames(FrameReader& reader, std::uint64_t most) {
  std::uint64_t frames = 0;
  while (frames < most && reader.next()) {
    reader.skip();
    ++frames;
  }
  return frames;
}

struct FrameCount {
  std::uint64_t frames = 0;
  std::string problem;  ///< why counting stopped early; empty: the file ended
};

/// Counts the frames from the reader's position on. An unreadable frame ends the count, because a
/// running simulation leaves an incomplete frame.
FrameCount count_frames(FrameReader& reader) {
  FrameCount count;
  try {
    while (skip_frames(reader, 1) == 1) ++count.frames;
  } catch (const InputError& error) {
    count.problem = error.what();
  }
  return count;
}

/// Throws the error that `frame`, which the reader has just read, is empty.
[[noreturn]] void fail_empty(FrameReader& reader, std::uint64_t frame) {
  const FilePlace place = reader.place();
  const std::string problem = "frame " + std::to_string(frame) + " has no particles";
  for (std::uint64_t later = frame + 1; reader.next(); ++later) {
    if (reader.skip() == 0) continue;
    place.fail(problem + ": the next frame with particles is frame " + std::to_string(later));
  }
  place.fail(problem + ", and neither has any later frame: choose an earlier frame");
}

/// Returns the first frame with particles. Sets `frame` to its number.
Particles read_filled(FrameReader& reader, std::uint64_t& frame) {
  for (frame = 0; reader.next(); ++frame) {
    Particles particles = reader.read();
    if (particles.count() == 0) continue;
    particles.facts.note("empty_frames", frame,
                         in_number(frame, "empty frame", "empty frames") + " at the start skipped");
    return particles;
  }
  reader.place().fail("the file has no particles: check that this is the right file");
}

/// Returns a numbered frame. The reader stands before the frame `next`.
Particles read_numbered(FrameReader& reader, std::uint64_t frame, std::uint64_t next = 0) {
  const std::uint64_t before = next + skip_frames(reader, frame - next);
  if (before < frame || !reader.next()) fail_without_frame(reader.place(), before, frame);
  Particles particles = reader.read();
  if (particles.count() == 0) fail_empty(reader, frame);
  return particles;
}

}  // namespace

void fail_without_frame(const FilePlace& place, std::uint64_t count, std::uint64_t asked) {
  place.fail("the file ends after " + std::to_string(count) + (count == 1 ? " frame" : " frames") +
             ": it has no frame " + std::to_string(asked) + " (the first frame is 0)");
}

bool FrameCursor::leads_to(const PackedFile& file, const ParticleRequest& request) const {
  return reader_ != nullptr && rewinds_ == file.rewinds() && request.frame_number() >= next_ &&
         request.numbers == request_.numbers && request.alternatives == request_.alternatives;
}

Particles FrameCursor::read(const PackedFile& file, const ParticleRequest& request,
                            const OpenFrames& open) {
  if (!leads_to(file, request)) {
    reader_.reset();
    request_ = request;
    next_ = 0;
    reader_ = open(request_);
    rewinds_ = file.rewinds();
  }
  // After an error the reader has no place in the file.
  std::unique_ptr<FrameReader> reader = std::move(reader_);
  Particles particles = read_numbered(*reader, request.frame_number(), next_);
  next_ = request.frame_number() + 1;
  particles.facts.frame = request.frame_number();
  reader_ = std::move(reader);
  return particles;
}

Particles read_frame(PackedFile& file, const ParticleRequest& request, const OpenFrames& open) {
  if (request.continues()) return request.cursor->read(file, request, open);
  std::uint64_t frame = request.frame_number();
  std::optional<FrameCount> count;
  if (request.frame && request.frame->last) {
    count = count_frames(*open(request));
    frame = count->frames == 0 ? 0 : count->frames - 1;
    file.rewind();
  }
  const std::unique_ptr<FrameReader> reader = open(request);
  Particles particles = request.frame ? read_numbered(*reader, frame) : read_filled(*reader, frame);
  particles.facts.frame = frame;
  if (request.all && !count) {
    count = count_frames(*reader);
    count->frames += frame + 1;
  }
  if (count) {
    particles.facts.frames = count->frames;
    particles.facts.note("unreadable_frames", count->problem.empty() ? 0 : 1,
                         "frame after the first " + std::to_string(count->frames) +
                             " cannot be read and ends the count: " + count->problem);
  }
  return particles;
}

}  // namespace parray::input
