#include "cli/input/select/particle_filter.h"

#include <algorithm>
#include <utility>

#include "cli/input/particles/file_place.h"
#include "cli/input/select/columns.h"
#include "cli/input/select/selection.h"
#include "common/base/error.h"
#include "common/base/text.h"

namespace parray::input {
namespace {

constexpr const char* hidden_by_default = "virtual";

std::uint64_t count_of(const ParticleMask& mask) {
  return static_cast<std::uint64_t>(std::ranges::count(mask, 1));
}

/// Removes the particles of `mask` from `shown`. Returns their number.
std::uint64_t take_out(const ParticleMask& mask, ParticleMask& shown) {
  std::uint64_t taken = 0;
  for (std::size_t i = 0; i < mask.size(); ++i) {
    taken += shown[i] & mask[i];
    shown[i] &= static_cast<std::uint8_t>(mask[i] ^ 1U);
  }
  return taken;
}

/// Collects which particles are shown, and a note for each reason why others are hidden.
class Shown {
 public:
  Shown(Particles& particles, int threads) : particles_(particles), threads_(threads) {}

  void select(const char* key, const std::string& text, const std::string& reason) {
    blaming(key, [&] {
      const std::string problem =
          "the selection leaves none of " + std::to_string(particles_.count()) + " particles: ";
      ParticleMask others = Selection(text).some(particles_, threads_, problem, "select more");
      for (std::uint8_t& value : others) value ^= 1U;
      take(others, std::string("not_in_") + key, reason);
      if (left() == 0) throw InputError(problem + "select more");
    });
  }

  void hide(const std::string& word) {
    blaming("hide", [&] {
      if (word == hidden_by_default) {  // the default must work for every file
        const ParticleMask sites = class_mask(hidden_by_default, particles_);
        if (count_of(sites) == particles_.count()) return;  // a bead model: nothing else to show
        return take(sites, "hidden_virtual", "hidden (virtual)");
      }
      const Selection selection = Selection::any_of({word});
      take(selection.mask(particles_, threads_), "hidden_" + word, "hidden (" + word + ")");
    });
  }

  /// Removes the hidden particles and adds the notes.
  void finish() {
    if (notes_.empty()) return;
    if (left() == 0) {
      throw SourceError("hide", "all " + std::to_string(particles_.count()) +
                                    " particles are hidden: hide fewer classes");
    }
    keep(particles_, mask_);
    auto& notes = particles_.facts.notes;
    notes.insert(notes.end(), std::make_move_iterator(notes_.begin()),
                 std::make_move_iterator(notes_.end()));
  }

 private:
  void take(const ParticleMask& mask, std::string key, const std::string& reason) {
    if (mask.empty()) return;
    if (mask_.empty()) mask_.assign(particles_.count(), 1);
    const std::uint64_t taken = take_out(mask, mask_);
    if (taken > 0) notes_.push_back({std::move(key), taken, particles_word(taken) + " " + reason});
  }
  [[nodiscard]] std::uint64_t left() const {
    return mask_.empty() ? particles_.count() : count_of(mask_);
  }

  Particles& particles_;
  int threads_;
  ParticleMask mask_;  // empty: all particles are shown
  std::vector<ParticleNote> notes_;
};

}  // namespace

std::string select_from(std::string_view text) {
  if (trimmed(text).empty()) {
    throw InputError("the selection is empty: write an expression, or \"all\"");
  }
  std::string selection(text);
  static_cast<void>(Selection(selection));
  return selection;
}

std::string slice_from(std::string_view text) {
  std::string slice(text);
  static_cast<void>(slice_as_selection(slice));
  return slice;
}

std::vector<std::string> hide_from(std::string_view text) {
  if (lower_case(trimmed(text)) == "none") return {};
  std::vector<std::string> words{hidden_by_default};
  for (const std::string_view part : split_at(',', text)) {
    std::string word = lower_case(trimmed(part));
    if (!place_in(words, word)) words.push_back(std::move(word));
  }
  check_hidden(words);
  return words;
}

void check_hidden(const std::vector<std::string>& words) {
  static_cast<void>(Selection::any_of(words));
}

void apply(const ParticleFilter& filter, Particles& particles, int threads) {
  Shown shown(particles, threads);
  for (const std::string& word :
       filter.hide.value_or(std::vector<std::string>{hidden_by_default})) {
    shown.hide(word);
  }
  if (!filter.slice.empty()) {
    shown.select("slice", slice_as_selection(filter.slice), "outside the slice");
  }
  if (!filter.select.empty()) shown.select("select", filter.select, "not selected");
  shown.finish();
}

}  // namespace parray::input
