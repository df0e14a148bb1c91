#pragma once

#include <cstdint>
#include <functional>
#include <memory>

#include "cli/input/particles/file_place.h"
#include "cli/input/particles/packed_file.h"
#include "cli/input/particles/particles.h"

namespace parray::input {

/// Reads the frames of a file from front to back. The first frame has the number 0. Each format
/// with several frames has its own reader. All members throw the errors of read_particles().
class FrameReader {
 public:
  virtual ~FrameReader() = default;

  /// Goes to the next frame. Then call either skip() or read(). Returns false if there is no frame.
  virtual bool next() = 0;
  /// Skips the frame and returns its number of particles.
  virtual std::uint64_t skip() = 0;
  /// Returns the frame with its time, cell and notes. It may have no particles.
  virtual Particles read() = 0;
  /// Returns the position of the reader.
  [[nodiscard]] virtual const FilePlace& place() const = 0;
};

/// A FrameReader that owns its input, a ParticleInput or a BinaryInput.
template <typename Input>
class FramesOf : public FrameReader {
 public:
  /// File and request must outlive this object.
  FramesOf(PackedFile& file, const ParticleRequest& request) : input_(file), request_(request) {}
  [[nodiscard]] const FilePlace& place() const override { return input_.place(); }

 protected:
  Input input_;
  const ParticleRequest& request_;
};

/// Makes a reader that is positioned before the first frame. The request must outlive the reader.
using OpenFrames = std::function<std::unique_ptr<FrameReader>(const ParticleRequest&)>;

/// The place in a file behind the frame that was read last. With it, reading frames in ascending
/// order reads the file once. Belongs to one PackedFile.
class FrameCursor {
 public:
  /// Returns whether read() can go on to the frame of the request without rewinding the file. This
  /// is so if the frame is later than the one read last, if the requested columns and alternative
  /// locations are the same, and if the file has not been rewound since.
  [[nodiscard]] bool leads_to(const PackedFile& file, const ParticleRequest& request) const;
  /// Reads the frame that the request chooses by its number. The file must be rewound unless
  /// leads_to() is true. Throws the errors of read_frame().
  Particles read(const PackedFile& file, const ParticleRequest& request, const OpenFrames& open);

 private:
  ParticleRequest request_;
  std::unique_ptr<FrameReader> reader_;  ///< null: no frame was read
  std::uint64_t next_ = 0;               ///< number, from 0, of the frame that next() goes to
  std::uint64_t rewinds_ = 0;            ///< of the file when the reader began
};

/// Returns the frame of `file` that request.frame chooses. Without a choice, returns the first
/// frame with particles. If the choice is `last`, counts the frames first and returns the last
/// complete one. An unreadable frame ends the count, and a note tells the user so.
///
/// If request.continues(), calls read() of request.cursor. `file` must be at its front, unless that
/// cursor leads_to() the frame. Sets facts.frame of the result. Sets facts.frames if it counted the
/// frames: for the last frame, and if `request.all` is true.
///
/// Throws InputError if the file does not have the frame or has no particles. Throws it also if the
/// request chooses a frame without particles; the message then names the next frame with particles,
/// if any.
Particles read_frame(PackedFile& file, const ParticleRequest& request, const OpenFrames& open);

/// Throws InputError: the file has `count` frames, and frame `asked` (from 0) is not one of them.
/// `place` is the end of the file.
[[noreturn]] void fail_without_frame(const FilePlace& place, std::uint64_t count,
                                     std::uint64_t asked);

/// Calls read_frame() with a `Reader` that has the constructor (PackedFile&, const
/// ParticleRequest&).
template <typename Reader>
Particles read_frame(PackedFile& file, const ParticleRequest& request) {
  return read_frame(file, request, [&file](const ParticleRequest& kept) {
    return std::make_unique<Reader>(file, kept);
  });
}

/// Factor that turns the nanometres of files of GROMACS and AMBER into angstrom.
inline constexpr double angstrom_per_nm = 10;

/// Returns the note that `count` particles were given in nanometres.
inline ParticleNote nm_note(std::uint64_t count) {
  return {"length_unit", count,
          in_number(count, "position", "positions") + " converted from nm to angstrom"};
}

}  // namespace parray::input
