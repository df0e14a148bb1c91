#pragma once

#include <cstdint>
#include <functional>
#include <memory>

#include "cli/input/particles/file_place.h"
#include "cli/input/particles/packed_file.h"
#include "cli/input/particles/particles.h"

namespace parray::input {

/// The frames of a file, one after the other, from front to back. Each format that holds several
/// has its own; all throw InputError as read_particles() does.
class FrameReader {
 public:
  virtual ~FrameReader() = default;

  /// Goes into the next frame, to where skip() or read() begins; false: there is none.
  virtual bool next() = 0;
  /// Passes over the frame; returns how many particles it has.
  virtual std::uint64_t skip() = 0;
  /// The frame, which may be without particles, with its time, cell and notes.
  virtual Particles read() = 0;
  /// Where the reader stands.
  [[nodiscard]] virtual const FilePlace& place() const = 0;
};

/// Makes a reader that stands before the first frame of a file at its beginning.
using OpenFrames = std::function<std::unique_ptr<FrameReader>()>;

/// The frame of `file` that the request chooses. Where it names none, empty ones are passed over;
/// `last` counts the frames in a pass of its own, and is the last that is complete. Sets
/// facts.frame, and facts.frames where they have been counted: for `last` and for `request.all`.
///
/// Throws InputError for a frame that the file does not have, and for an empty one that is asked
/// for, with the next that has particles.
Particles read_frame(PackedFile& file, const ParticleRequest& request, const OpenFrames& open);

/// The file has so many frames, and not the one that was asked for. `place` is where it ends.
[[noreturn]] void fail_without_frame(const FilePlace& place, std::uint64_t count,
                                     std::uint64_t asked);

/// The same by a `Reader`, made from (PackedFile&, const ParticleRequest&).
template <typename Reader>
Particles read_frame(PackedFile& file, const ParticleRequest& request) {
  return read_frame(file, request, [&] { return std::make_unique<Reader>(file, request); });
}

}  // namespace parray::input
