#include "cli/input/formats/gemmi_seam.h"

#include <gemmi/cif.hpp>
#include <gemmi/symmetry.hpp>

namespace parray::input {
namespace {

namespace pegtl = tao::pegtl;
namespace rules = gemmi::cif::rules;

/// Passes the matches of the grammar to the visitor. A rule without its own Action does nothing.
template <typename Rule>
struct Action : pegtl::nothing<Rule> {};

template <>
struct Action<rules::datablockheading> {
  static void apply0(CifVisitor& visitor) { visitor.start_block(); }
};
template <>
struct Action<rules::str_loop> {
  static void apply0(CifVisitor& visitor) { visitor.start_loop(); }
};
template <>
struct Action<rules::loop> {  // without its text, because the buffer no longer contains the start
                              // of the text
  static void apply0(CifVisitor& visitor) { visitor.end_loop(); }
};

struct TagAction {
  template <typename Input>
  static void apply(const Input& in, CifVisitor& visitor) {
    visitor.tag(in.string_view(), in.iterator().line);
  }
};
template <>
struct Action<rules::item_tag> : TagAction {};
template <>
struct Action<rules::loop_tag> : TagAction {};

struct ValueAction {
  template <typename Input>
  static void apply(const Input& in, CifVisitor& visitor) {
    visitor.value(in.string_view(), in.iterator().line);
  }
};
template <>
struct Action<rules::item_value> : ValueAction {};
template <>
struct Action<rules::loop_value> : ValueAction {};

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
    pegtl::parse<rules::file, Action, gemmi::cif::Errors>(in, visitor);
  } catch (const pegtl::parse_error& error) {
    throw CifError(std::string(error.message()), error.positions().front().line);
  } catch (const std::overflow_error&) {  // thrown by the buffer
    throw CifError("a text has more than " + std::to_string(max_cif_text_bytes) + " bytes",
                   in.line());
  }
}

std::string cif_text(const std::string& value) { return gemmi::cif::as_string(value); }

}  // namespace parray::input
