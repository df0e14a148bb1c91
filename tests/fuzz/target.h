#pragma once

#include <span>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

#include "common/scene/scene.h"
#include "common/scene/settings.h"
#include "tests/support/rooms.h"

/// The code that reads what comes from outside, each kind of input as one function of bytes: for
/// libFuzzer (tests/fuzz/run), and for the ordinary tests, which feed it seeds and old finds.
namespace parray::fuzz {

/// A reader has broken a promise of its header.
class Violation : public std::logic_error {
 public:
  using std::logic_error::logic_error;
};

struct Target {
  std::string_view name;
  /// True: the input was taken, false: it was refused as its reader promises to. Throws Violation;
  /// an exception that no header names passes through.
  bool (*run)(std::string_view input);
  /// Inputs to begin with, nearly all of which are taken. The same on every machine.
  std::vector<std::string> (*seeds)();
};

extern const Target scene_target;      ///< a scene file, either format
extern const Target particles_target;  ///< a letter for the name, then a particle file
extern const Target messages_target;   ///< a letter for the form, then a message's frames
extern const Target bulk_target;       ///< a letter for the kind, then what a bulk frame holds
extern const Target state_target;      ///< a letter for the kind, then what is kept of a job
extern const Target picture_target;    ///< a picture's file
extern const Target selection_target;  ///< a letter for the kind, then a text about particles
extern const Target keys_target;       ///< a letter for the kind, then a file of keys
extern const Target chunks_target;     ///< a byte for the pieces, then a chunked HTTP body

/// All of them.
std::span<const Target* const> targets();
/// Throws std::invalid_argument.
const Target& target_named(std::string_view name);

/// Throws Violation unless `kept`.
void promise(bool kept, const std::string& what);
/// An error's text for people: one line, printable, not endless.
void promise_one_line(std::string_view message);
/// What every reader of scenes promises to those who trace and send them: the scene's binary form
/// reads back as itself, and everything automatic can be decided.
void promise_usable(const Scene& scene, const RenderSettings& settings);

/// What whoever lets settings in promises to the coordinator: a job of them, whose passes `begun`
/// an earlier life has begun, has a pass to begin with. Large pictures are not looked at.
void promise_startable(const RenderSettings& settings, const std::vector<std::uint64_t>& begun = {},
                       std::uint32_t tile = 0);

/// Takes the first letter of `input`; 0 when it is empty.
char take_letter(std::string_view& input);

}  // namespace parray::fuzz
