#include "cli/input/formats/gemmi_seam.h"

#include <gemmi/cif.hpp>
#include <gemmi/symmetry.hpp>

namespace parray::input {
namespace {

namespace pegtl = tao::pegtl;
namespace rules = gemmi::cif::rules;

/// What the grammar meets, passed on. A rule without a Meet of its own means nothing.
template <typename Rule>
struct Meet : pegtl::nothing<Rule> {};

template <>
struct Meet<rules::datablockheading> {
  static void apply0(CifVisitor& visitor) { visitor.start_block(); }
};
template <>
struct Meet<rules::str_loop> {
  static void apply0(CifVisitor& visitor) { visitor.start_loop(); }
};
template <>
struct Meet<rules::loop> {  // without its text, of which the buffer has forgotten the beginning
  static void apply0(CifVisitor& visitor) { visitor.end_loop(); }
};

struct MeetTag {
  template <typename Input>
  static void apply(const Input& in, CifVisitor& visitor) {
    visitor.tag(in.string_view(), in.iterator().line);
  }
};
template <>
struct Meet<rules::item_tag> : MeetTag {};
template <>
struct Meet<rules::loop_tag> : MeetTag {};

struct MeetValue {
  template <typename Input>
  static void apply(const Input& in, CifVisitor& visitor) {
    visitor.value(in.string_view(), in.iterator().line);
  }
};
template <>
struct Meet<rules::item_value> : MeetValue {};
template <>
struct Meet<rules::loop_value> : MeetValue {};

using Read = std::function<std::size_t(char*, std::size_t)>;
constexpr std::size_t chunk_bytes = std::size_t{1} << 16;
using Input = pegtl::buffer_input<Read, pegtl::eol::lf_crlf, std::string, chunk_bytes>;

}  // namespace

std::vector<std::array<double, 12>> operations_of_space_group(const std::string& name) {
  const gemmi::SpaceGroup* group = gemmi::find_spacegroup_by_name(name);
  if (group == nullptr) {
    for (const gemmi::SpaceGroup& known : gemmi::spacegroup_tables::main) {
      if (name == known.hall) group = &known;
    }
  }
  std::vector<std::array<double, 12>> operations;
  if (group == nullptr) return operations;
  for (const gemmi::Op& op : group->operations()) {
    std::array<double, 12> numbers{};
    for (std::size_t row = 0; row < 3; ++row) {
      for (std::size_t i = 0; i < 3; ++i) {
        numbers[4 * row + i] = static_cast<double>(op.rot[row][i]) / gemmi::Op::DEN;
      }
      numbers[4 * row + 3] = static_cast<double>(op.tran[row]) / gemmi::Op::DEN;
    }
    operations.push_back(numbers);
  }
  return operations;
}

void parse_cif(const Read& read, CifVisitor& visitor) {
  Input in("", max_cif_text_bytes, read);
  try {
    pegtl::parse<rules::file, Meet, gemmi::cif::Errors>(in, visitor);
  } catch (const pegtl::parse_error& error) {
    throw CifError(std::string(error.message()), error.positions().front().line);
  } catch (const std::overflow_error&) {  // the buffer's
    throw CifError("a text of more than " + std::to_string(max_cif_text_bytes) + " bytes",
                   in.line());
  }
}

std::string cif_text(const std::string& value) { return gemmi::cif::as_string(value); }

}  // namespace parray::input
