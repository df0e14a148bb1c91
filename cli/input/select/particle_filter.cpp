#include "cli/input/select/particle_filter.h"

#include <algorithm>
#include <utility>

#include "cli/input/particles/particle_text.h"
#include "cli/input/particles/source_error.h"
#include "cli/input/select/column_names.h"
#include "cli/input/select/particle_classes.h"
#include "cli/input/select/selection.h"
#include "common/base/error.h"
#include "common/base/printable.h"

namespace parray::input {
namespace {

constexpr const char* hidden_by_default = "virtual";

/// Throws SourceError instead of other InputErrors: `key` is at fault.
template <typename Work>
auto blaming(const char* key, const Work& work) {
  try {
    return work();
  } catch (const UnknownNumber&) {
    throw;
  } catch (const InputError& error) {
    throw SourceError(key, error.what());
  }
}

std::uint64_t count_of(const ParticleMask& mask) {
  return static_cast<std::uint64_t>(std::ranges::count(mask, 1));
}

/// Takes those of `mask` out of `shown`; returns how many that are.
std::uint64_t take_out(const ParticleMask& mask, ParticleMask& shown) {
  std::uint64_t taken = 0;
  for (std::size_t i = 0; i < mask.size(); ++i) {
    taken += shown[i] & mask[i];
    shown[i] &= static_cast<std::uint8_t>(mask[i] ^ 1U);
  }
  return taken;
}

/// What is wrong with the text of a member gets its place.
template <typename Read>
auto checked(const JsonFields& fields, std::string_view key, const Read& read) {
  try {
    return read();
  } catch (const InputError& error) {
    fields.place().at(key).fail(fields.find(key)->line, error.what());
  }
}

/// Which particles are shown, and a note for every reason why others are not.
class Shown {
 public:
  Shown(Particles& particles, int threads) : particles_(particles), threads_(threads) {}

  void select(const char* key, const std::string& text, const std::string& reason) {
    blaming(key, [&] {
      const Selection selection(text);
      ParticleMask others = selection.mask(particles_, threads_);
      for (std::uint8_t& value : others) value ^= 1U;
      const std::uint64_t kept = others.size() - count_of(others);
      if (kept == 0) fail_empty(selection.what_there_is(particles_));
      take(others, std::string("not_in_") + key, reason);
      if (left() == 0) fail_empty("");
    });
  }

  void hide(const std::string& word) {
    blaming("hide", [&] {
      if (word == hidden_by_default) {  // which every file can be asked for
        const ParticleMask sites = class_mask(ParticleClass::virtual_site, particles_);
        if (count_of(sites) == particles_.count()) return;  // a model of beads: nothing else to see
        return take(sites, "hidden_virtual", "hidden (virtual)");
      }
      const Selection selection = Selection::any_of({word});
      take(selection.mask(particles_, threads_), "hidden_" + word, "hidden (" + word + ")");
    });
  }

  /// Leaves those that are shown.
  void finish() {
    if (notes_.empty()) return;
    if (left() == 0) {
      throw SourceError("hide", "all " + std::to_string(particles_.count()) +
                                    " particles are hidden: hide fewer classes, or none");
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
    if (taken > 0) {
      notes_.push_back({std::move(key), taken, particles_word(taken) + " " + reason});
    }
  }
  [[nodiscard]] std::uint64_t left() const {
    return mask_.empty() ? particles_.count() : count_of(mask_);
  }
  [[noreturn]] void fail_empty(const std::string& what_there_is) const {
    throw InputError("none of " + std::to_string(particles_.count()) + " particles is left: " +
                     (what_there_is.empty() ? "select more" : what_there_is));
  }

  Particles& particles_;
  int threads_;
  ParticleMask mask_;  // empty: all
  std::vector<ParticleNote> notes_;
};

}  // namespace

std::string select_from(const std::string& text) {
  if (trimmed(text).empty()) throw InputError("the selection is empty: write one, or all");
  static_cast<void>(Selection(text));
  return text;
}

std::string slice_from(const std::string& text) {
  static_cast<void>(slice_as_selection(text));
  return text;
}

std::vector<std::string> hide_from(std::string_view text) {
  if (trimmed(text) == "none") return {};
  std::vector<std::string> words{hidden_by_default};
  for (std::size_t begin = 0; begin <= text.size();) {
    const std::size_t comma = std::min(text.find(',', begin), text.size());
    std::string word = lower_case(trimmed(text.substr(begin, comma - begin)));
    if (std::ranges::find(words, word) == words.end()) words.push_back(std::move(word));
    begin = comma + 1;
  }
  static_cast<void>(Selection::any_of(words));
  return words;
}

ParticleFilter read_particle_filter(const JsonFields& fields) {
  ParticleFilter out;
  if (fields.find("select") != nullptr) {
    const std::string& text = fields.string("select");
    out.select = checked(fields, "select", [&] { return select_from(text); });
  }
  if (fields.find("slice") != nullptr) {
    const std::string& text = fields.string("slice");
    out.slice = checked(fields, "slice", [&] { return slice_from(text); });
  }
  const JsonValue* const hide = fields.find("hide");
  if (hide == nullptr) return out;
  const JsonPlace place = fields.place().at("hide");
  if (hide->kind != JsonKind::array) {
    place.fail(hide->line, "not a list: write words in brackets, as [\"virtual\", \"water\"]");
  }
  out.hide.emplace();
  for (std::size_t i = 0; i < hide->items.size(); ++i) {
    out.hide->push_back(read_string(hide->items[i], place.at(i)));
  }
  checked(fields, "hide", [&] { return Selection::any_of(*out.hide); });
  return out;
}

std::set<std::string, std::less<>> numbers_of(const ParticleFilter& filter) {
  return filter.select.empty() ? std::set<std::string, std::less<>>{}
                               : Selection(filter.select).numbers();
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
  if (!filter.select.empty()) {
    shown.select("select", filter.select, "not selected");
  }
  shown.finish();
}

}  // namespace parray::input
