#include "cli/input/color/particle_coloring.h"
#include "cli/input/select/particle_filter.h"
#include "cli/input/select/selection.h"
#include "common/base/error.h"
#include "common/base/printable.h"
#include "tests/fuzz/target.h"
#include "tests/support/rooms.h"

namespace parray::fuzz {
namespace {

/// Particles that have every column that a selection may ask about.
const Particles& particles() {
  static const Particles all = [] {
    Particles out;
    constexpr std::size_t count = 600;  // more than are looked at together
    for (std::size_t i = 0; i < count; ++i) {
      const auto place = static_cast<double>(i);
      out.positions.push_back({place, 1e3 / (1 + place), -place});
      out.radii.push_back(1 + place);
      out.elements.push_back(static_cast<std::uint8_t>(i % 9));
      out.residue_numbers.push_back(static_cast<std::int32_t>(i / 3) - 20);
      for (NameColumn* column : {&out.types, &out.atom_names, &out.residue_names, &out.chains}) {
        column->index.push_back(static_cast<std::uint32_t>(i / 7 % 5));
      }
    }
    out.types.names = {"1", "2", "a b", "", "C"};
    out.atom_names.names = {"CA", "O5'", "MW", "N", "FE"};
    out.residue_names.names = {"ALA", "HOH", "DA", "NA", "HEM"};
    out.chains.names = {"A", "B", "a", "", "AA"};
    return out;
  }();
  return all;
}

/// An error names the place in one line.
template <typename Work>
bool taken(const Work& work) {
  try {
    work();
    return true;
  } catch (const InputError& error) {
    promise_one_line(error.what());
    return false;
  }
}

/// Not of a selection, its opposite and both of them: each particle is in one of the two.
void promise_opposites(std::string_view text, const Selection& selection) {
  Particles with_numbers = particles();
  for (const std::string& name : selection.numbers()) {
    with_numbers.numbers.push_back({name, std::vector<double>(with_numbers.count(), 0.5)});
  }
  const ParticleMask mask = selection.mask(with_numbers);
  promise(mask.size() == with_numbers.count(), "a value for each particle");
  promise(selection.mask(with_numbers, 3) == mask, "the same by three threads");
  promise_one_line("x" + printable(selection.what_there_is(with_numbers), 2900));
  const std::string opposite = "not (" + std::string(text) + ")";
  if (opposite.size() > 4096) return;
  taken([&] {  // may be nested too deeply
    const ParticleMask others = Selection(opposite).mask(with_numbers);
    for (std::size_t i = 0; i < mask.size(); ++i) {
      promise(mask[i] + others[i] == 1, "a particle is selected or not");
    }
  });
}

/// A letter for the kind of text, then the text.
bool run(std::string_view input) {
  switch (take_letter(input)) {
    case 's': return taken([&] { promise_opposites(input, Selection(input)); });
    case 'l':
      return taken(
          [&] { static_cast<void>(Selection(slice_as_selection(input)).mask(particles())); });
    case 'h':
      return taken([&] {
        Particles some = particles();
        apply({.select = {}, .slice = {}, .hide = hide_from(input)}, some);
      });
    case 'r':
      return taken([&] {
        const TextRange range = color_range_from(input);
        promise(color_range_from(text_of(range)) == range, "a range as written");
      });
    default: return false;
  }
}

std::vector<std::string> seeds() {
  return {"sall and not none",
          "schain A \"B\" or (resname HOH ALA, DA and index 0:99 120)",
          "swithin 5.5 of element C N unknown and not same residue as resid -3:7",
          "s10 < z <= 20 && x*x + y*y < 2.5e1 | -abs(fx - 0.5) >= sqrt(c_pe[1]) / 2 % 3",
          "swater or protein or nucleic or ion or hetero or ligand or backbone or virtual",
          "s!(name C* or type 1) and radius != 3 and \"a b\" = 1",
          "lz=10:20,x=40%:60%,y=:3",
          "hwater, hydrogens",
          "hnone",
          "r-1:1e3",
          "r1%:99.5%"};
}

}  // namespace

const Target selection_target{"selection", run, seeds};

}  // namespace parray::fuzz
