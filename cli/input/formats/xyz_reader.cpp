#include <algorithm>
#include <set>

#include "cli/input/formats/readers.h"
#include "cli/input/formats/xyz_comment.h"
#include "cli/input/particles/frames.h"
#include "cli/input/particles/particle_input.h"
#include "cli/input/particles/particle_text.h"
#include "common/base/printable.h"

namespace parray::input {
namespace {

constexpr std::size_t least_row_bytes = 8;  // "C 0 0 0\n"

void check_width(std::size_t found, const XyzLayout& layout, const FilePlace& place) {
  if (found == layout.columns || (found > layout.columns && !layout.exact)) return;
  place.fail(std::to_string(found) + " columns where " + std::to_string(layout.columns) +
             " are needed: " +
             (layout.exact ? "write as many as Properties announces"
                           : "write a name and three coordinates"));
}

/// Whether they are 1, 2, 3 ... in some order, without a gap.
bool count_from_one(const std::vector<std::string>& names) {
  std::set<std::uint64_t> numbers;
  for (const std::string& name : names) {
    const std::optional<std::uint64_t> number = natural_in(name);
    if (!number || *number == 0 || *number > names.size()) return false;
    numbers.insert(*number);
  }
  return numbers.size() == names.size();
}

bool are_numbers(const std::vector<std::string>& names) {
  return std::ranges::all_of(names, [](const auto& name) { return natural_in(name).has_value(); });
}

/// LAMMPS writes numbers of types where elements stand. Numbers are such in a frame with its
/// comment, and where they go from 1 on without a gap: no chemistry has all of H, He, Li. Others
/// are atomic numbers.
void tell_types_from_elements(std::string_view comment, Particles& particles) {
  const std::vector<std::string>& names = particles.types.names;
  if (particles.elements.empty() || names.empty()) return;
  const bool types = is_lammps_comment(comment) ? are_numbers(names) : count_from_one(names);
  if (!types) {
    const auto numbers = std::ranges::count_if(particles.types.index, [&](std::uint32_t name) {
      return natural_in(names[name]).has_value();
    });
    if (numbers > 0) {
      particles.facts.notes.push_back({"guessed_elements", static_cast<std::uint64_t>(numbers),
                                       "elements told by atomic numbers"});
    }
    return;
  }
  particles.elements = {};
  particles.facts.notes.push_back({"numbers_as_types", particles.count(),
                                   "names that are numbers taken for types, not for elements"});
}

/// Each frame is a count, a comment and so many rows.
class XyzFrames final : public FrameReader {
 public:
  XyzFrames(PackedFile& file, const ParticleRequest& request) : request_(request), input_(file) {
    at_count_ = input_.next_line();
  }

  bool next() override {
    if (!at_count_) return false;
    count_ = count_field(trimmed(input_.line()), input_.place());
    if (!input_.next_line()) input_.fail("the file ends before its comment line: is it complete?");
    return true;
  }

  std::uint64_t skip() override {
    for (std::uint64_t i = 0; i < count_; ++i) {
      if (!input_.next_line()) input_.fail("the file ends within a frame: is it complete?");
    }
    go_to_count();
    return count_;
  }

  Particles read() override {
    const std::string comment(input_.line());
    XyzLayout layout = xyz_layout(comment, input_.place());
    ParticleColumns columns(input_.place());
    columns.expect(std::min(count_, input_.bytes_left().value_or(0) / least_row_bytes + 1));
    want_numbers(layout.others, request_, layout.row, columns);
    Fields row;
    for (std::uint64_t i = 0; i < count_; ++i) {
      if (!input_.next_line()) {
        input_.fail("the file ends after " + std::to_string(i) + " of " + std::to_string(count_) +
                    " particles: is it complete?");
      }
      split_at_blanks(input_.line(), row);
      check_width(row.size(), layout, input_.place());
      add_row(row, layout.row, input_.place(), columns);
    }
    go_to_count();
    Particles particles = columns.finish_frame();
    tell_types_from_elements(comment, particles);
    particles.cell = xyz_cell(comment);
    particles.facts.time = xyz_time(comment);
    return particles;
  }

  [[nodiscard]] const FilePlace& place() const override { return input_.place(); }

 private:
  /// After a frame comes another, which starts with its count, or nothing.
  void go_to_count() {
    at_count_ = input_.next_filled_line();
    if (!at_count_ || natural_in(trimmed(input_.line()))) return;
    input_.fail("text after the last particle: is the count of the frame right?");
  }

  const ParticleRequest& request_;
  ParticleInput input_;
  bool at_count_ = false;  // of the next frame
  std::uint64_t count_ = 0;
};

}  // namespace

Particles read_xyz(PackedFile& file, const ParticleRequest& request) {
  return read_frame<XyzFrames>(file, request);
}

}  // namespace parray::input
