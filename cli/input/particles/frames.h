#pragma once

#include <cstdint>
#include <functional>
#include <memory>

#include "cli/input/particles/file_place.h"
#include "cli/input/particles/packed_file.h"
#include "cli/input/particles/particles.h"

namespace parray::input {

/// Reads the frames of a file from front to back. Every format with several frames has its own. All
/// members throw InputError as read_particles() does.
class FrameReader {
 public:
  virtual ~FrameReader() = default;

  /// Goes to the next frame, where skip() or read() begins. Returns false if there is none.
  virtual bool next() = 0;
  /// Skips the frame and returns its number of particles.
  virtual std::uint64_t skip() = 0;
  /// Returns the frame with its time, cell and notes. It may have no particles.
  virtual Particles read() = 0;
  /// Returns the position of the reader.
  [[nodiscard]] virtual const FilePlace& place() const = 0;
};

/// A FrameReader with its input, a ParticleInput or BinaryInput.
template <typename Input>
class FramesOf : public FrameReader {
 public:
  explicit FramesOf(PackedFile& file) : input_(file) {}
  [[nodiscard]] const FilePlace& place() const override { return input_.place(); }

 protected:
  Input input_;
};

/// Makes a reader that stands before the first frame.
using OpenFrames = std::function<std::unique_ptr<FrameReader>()>;

/// Returns the frame of `file` that the request chooses. Without a choice it returns the first
/// frame with particles. `last` counts the frames first and chooses the last complete one. Sets
/// facts.frame; sets facts.frames if the frames were counted, for `last` and for `request.all`.
///
/// Throws InputError for a frame that the file does not have, and for an empty frame that the
/// request names; the message names the next frame with particles.
Particles read_frame(PackedFile& file, const ParticleRequest& request, const OpenFrames& open);

/// Throws InputError: the file has `count` frames, and the one that was asked for is not among
/// them. `place` is the end of the file.
[[noreturn]] void fail_without_frame(const FilePlace& place, std::uint64_t count,
                                     std::uint64_t asked);

/// The same for a `Reader` with the constructor (PackedFile&, const ParticleRequest&).
template <typename Reader>
Particles read_frame(PackedFile& file, const ParticleRequest& request) {
  return read_frame(file, request, [&] { return std::make_unique<Reader>(file, request); });
}

/// Files of GROMACS and AMBER may give lengths in nm; the readers turn them into angstrom.
inline constexpr double angstrom_per_nm = 10;

/// Returns the note that says so of `count` particles.
inline ParticleNote nm_note(std::uint64_t count) {
  return {"length_unit", count, "positions given in nm, turned into angstrom"};
}

}  // namespace parray::input
