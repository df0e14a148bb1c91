#include "cli/input/select/particle_classes.h"

#include <unordered_map>

#include "cli/input/particles/residues.h"

namespace parray::input {
namespace {

/// What tells the class of a particle.
struct ParticleNames {
  std::string_view residue;
  std::string_view atom;
  std::uint8_t element;
};

bool is_of(ParticleClass wanted, const ParticleNames& names) {
  switch (wanted) {
    case ParticleClass::water:
      return is_water(names.residue);
    case ParticleClass::protein:
      return is_amino_acid(names.residue);
    case ParticleClass::nucleic:
      return is_nucleotide(names.residue);
    case ParticleClass::ion:
      return is_ion(names.residue, names.atom);
    case ParticleClass::virtual_site:
      break;
  }
  return is_virtual_site(names.residue, names.atom, names.element);
}

/// Answers a question once for each distinct combination of names.
class Answers {
 public:
  Answers(ParticleClass wanted, const Particles& particles)
      : wanted_(wanted), particles_(particles) {}

  bool of(std::size_t i) {
    const std::uint32_t residue = number(particles_.residue_names, i);
    const std::uint32_t atom = number(particles_.atom_names, i);
    const std::uint8_t element = particles_.elements.empty() ? 0 : particles_.elements[i];
    if (known_ && residue == residue_ && atom == atom_ && element == element_) return answer_;
    known_ = true;
    residue_ = residue;
    atom_ = atom;
    element_ = element;
    const std::uint64_t key = (std::uint64_t{residue} << 32U | atom) * 256 + element;
    const auto [found, is_new] = answers_.try_emplace(key, false);
    if (is_new) {
      found->second = is_of(
          wanted_, {name(particles_.residue_names, i), name(particles_.atom_names, i), element});
    }
    answer_ = found->second;
    return answer_;
  }

 private:
  static std::uint32_t number(const NameColumn& column, std::size_t i) {
    return column.empty() ? 0 : column.index[i];
  }
  static std::string_view name(const NameColumn& column, std::size_t i) {
    return column.empty() ? std::string_view() : std::string_view(column.of(i));
  }

  ParticleClass wanted_;
  const Particles& particles_;
  std::unordered_map<std::uint64_t, bool> answers_;
  bool known_ = false;  // of the particle before: neighbours are alike
  std::uint32_t residue_ = 0;
  std::uint32_t atom_ = 0;
  std::uint8_t element_ = 0;
  bool answer_ = false;
};

}  // namespace

ParticleClass class_of(std::string_view word) {
  if (word == "water") return ParticleClass::water;
  if (word == "protein") return ParticleClass::protein;
  return word == "nucleic" ? ParticleClass::nucleic : ParticleClass::ion;
}

ParticleMask class_mask(ParticleClass wanted, const Particles& particles) {
  if (particles.residue_names.empty() && particles.atom_names.empty()) return {};
  Answers answers(wanted, particles);
  ParticleMask mask;
  for (std::size_t i = 0; i < particles.count(); ++i) {
    if (!answers.of(i)) continue;
    if (mask.empty()) mask.resize(particles.count());
    mask[i] = 1;
  }
  return mask;
}

}  // namespace parray::input
