#include "cli/input/formats/bond_fields.h"

#include <algorithm>
#include <string>

#include "cli/input/particles/stated_bonds.h"
#include "common/base/printable.h"
#include "common/base/text.h"

namespace parray::input {
namespace {

/// Returns the bond between the atoms that `index_of` finds for two texts, in this order.
StatedBond bond_of(std::string_view one, std::string_view other, const FilePlace& place,
                   const auto& index_of) {
  const std::uint64_t first = index_of(one);
  const std::uint64_t second = index_of(other);
  if (first == second) {
    place.fail("atom " + printable(one) + " bonds to itself: remove the bond");
  }
  return bond_between(first, second);
}

}  // namespace

StatedBond bond_field(std::string_view one, std::string_view other, std::uint64_t atoms,
                      const FilePlace& place) {
  return bond_of(one, other, place, [&](std::string_view text) {
    const std::optional<std::uint64_t> number = natural_in(text);
    if (number && *number >= 1 && *number <= atoms) return *number - 1;
    place.fail("a bond has the atom '" + printable(text) + "': use a number from 1 to " +
               std::to_string(atoms));
  });
}

ParticleNote unknown_bonds_note(std::uint64_t count) {
  return {"unknown_bonds", count,
          in_number(count, "bond", "bonds") +
              " left out, because an atom of the bond is missing or occurs several times"};
}

void AtomNumbers::add(std::optional<std::int64_t> number) {
  const std::uint32_t place = atoms_++;
  if (!number) return;
  sorted_ = false;
  if (!runs_.empty() && *number == runs_.back().end() &&
      place == runs_.back().place + runs_.back().count) {
    ++runs_.back().count;
  } else {
    runs_.push_back({*number, place, 1, 0});
  }
}

void AtomNumbers::sort_runs() {
  std::ranges::sort(runs_, {}, &Run::number);
  for (std::size_t i = 0; i < runs_.size(); ++i) {
    runs_[i].end_so_far = std::max(runs_[i].end(), i > 0 ? runs_[i - 1].end_so_far : 0);
  }
  sorted_ = true;
}

std::optional<std::uint32_t> AtomNumbers::find(std::int64_t number) {
  if (!sorted_) sort_runs();
  std::optional<std::uint32_t> found;
  auto run = std::ranges::upper_bound(runs_, number, {}, &Run::number);
  while (run != runs_.begin() && (--run)->end_so_far > number) {
    if (run->end() <= number) continue;
    if (found) return {};
    found = run->place + static_cast<std::uint32_t>(number - run->number);
  }
  return found;
}

StatedBond AtomNumbers::bond(std::string_view one, std::string_view other, const FilePlace& place) {
  return bond_of(one, other, place, [&](std::string_view text) {
    const auto number = parsed<std::int64_t>(text);
    const auto found = number ? find(*number) : std::nullopt;
    if (found) return *found;
    place.fail("a bond has the atom '" + printable(text) +
               "', but no atom, or more than one, has this number: check the numbers of the atoms");
  });
}

}  // namespace parray::input
