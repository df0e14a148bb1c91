#include "common/input/formats/gemmi_seam.h"

#include <gemmi/cif.hpp>
#include <gemmi/pdb.hpp>

namespace parray {
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

PdbAtom parse_pdb_atom(const std::string& record) {
  // One record at a time: gemmi's loop over files keeps the whole structure, and does not say which
  // line is wrong. Without the charge, which is of no use here and refused where it is odd.
  constexpr std::size_t charge_column = 78;
  const gemmi::Structure structure =
      gemmi::read_pdb_string(record.substr(0, charge_column) + "\n", "");
  const gemmi::Chain& chain = structure.models.at(0).chains.at(0);
  const gemmi::Residue& residue = chain.residues.at(0);
  const gemmi::Atom& atom = residue.atoms.at(0);
  PdbAtom result;
  result.chain = chain.name;
  result.residue_number = residue.seqid.str();
  result.residue_name = residue.name;
  result.name = atom.name;
  result.atomic_number = atom.element.atomic_number();
  result.alternative_location = atom.altloc != '\0';
  result.occupancy = static_cast<double>(atom.occ);
  return result;
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

}  // namespace parray
