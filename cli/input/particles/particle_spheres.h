#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "cli/input/color/legend.h"
#include "cli/input/color/particle_colors.h"
#include "cli/input/particles/particles.h"
#include "cli/input/scene_file/material_names.h"
#include "cli/input/scene_file/particle_source.h"
#include "common/scene/scene.h"

/// Turns particles into spheres: decides where their materials and radii come from. A rule is
/// decided if it is not `automatic`, and supported if problem_with() returns an empty text for it.
namespace parray::input {

/// Return the rule that `automatic` means for these columns. Return `automatic` if the columns
/// support no rule. Return other rules unchanged.
ParticleMaterial decided(const ParticleMaterial& asked, const Particles& particles);
ParticleRadius decided(const ParticleRadius& asked, const Particles& particles,
                       bool crystal = false);

/// Return why a decided rule is not possible for the file `name`. If a column is missing, the text
/// is "NAME has no ...: use A, B or ...". If the material is unknown, or is a dielectric for
/// `color_by`, the text is about the material. Return an empty text if the rule is possible.
/// `otherwise` is a text for the message that names a choice that is always possible.
std::string problem_with(const ParticleMaterial& material, const Particles& particles,
                         const MaterialNames& materials, const std::string& name,
                         std::string_view otherwise = "the name of a material");
std::string problem_with(const ParticleRadius& radius, const Particles& particles,
                         const std::string& name);

/// Returns the meaning of the particles' colours under a decided, supported rule other than
/// `color_by`. Elements come in the order of their numbers with unknown ones last, types in
/// reading_order(), with the name nameless_category for the empty type. Contains those that
/// particles have, and those in `names`. Returns an empty legend for other rules.
Legend legend_of(const Particles& particles, const ParticleMaterial& material,
                 const MaterialNames& materials, const std::vector<std::string>& names = {});

/// Appends a sphere for each particle, in order, to `scene`. Materials of the scene stay distinct
/// and in the order of their first use. The rules of `look` must be decided and supported.
/// `colors` belong to the particles if the rule of the material is `color_by`; otherwise they are
/// not used. `file` is the name of the file for messages.
///
/// Frees columns that the rules do not need before it allocates. Throws InputError "FILE: problem:
/// remedy" if spheres or distinct materials exceed limits.h; `scene` is unusable then.
void append_spheres(Particles particles, const ParticleColors& colors, const ParticleLook& look,
                    const std::string& file, const MaterialNames& materials, Scene& scene,
                    int threads = 1);

}  // namespace parray::input
