#pragma once

#include <string>
#include <string_view>

#include "cli/input/color/legend.h"
#include "cli/input/color/particle_paint.h"
#include "cli/input/particles/particles.h"
#include "cli/input/scene_file/material_names.h"
#include "cli/input/scene_file/particle_source.h"
#include "common/scene/scene.h"

/// One sphere a particle: where its surface and its radius come from.
namespace parray::input {

/// The rule that `automatic` stands for with these columns; `automatic` still where none of them
/// helps. Any other rule stays as it is.
ParticleMaterial decided(const ParticleMaterial& asked, const Particles& particles);
ParticleRadius decided(const ParticleRadius& asked, const Particles& particles);

/// Why these columns, of a file called `name`, do not support a decided rule: "NAME has no ...: use
/// A, B or ...". Empty when they do. `otherwise` is what a user can always ask for.
std::string problem_with(const ParticleMaterial& material, const Particles& particles,
                         const MaterialNames& materials, const std::string& name,
                         std::string_view otherwise = "the name of a material");
std::string problem_with(const ParticleRadius& radius, const Particles& particles,
                         const std::string& name);

/// What the particles' colours mean under a rule that is decided and without problem, unless they
/// are painted. Elements come by atomic number, those that are unknown last; types in the order of
/// the file. Empty under any other rule, where colours stand for nothing.
Legend legend_of(const Particles& particles, const ParticleMaterial& material,
                 const MaterialNames& materials);

/// Appends a sphere for each particle, in order, to `scene`, whose materials stay distinct and in
/// the order of their first use. The rules of `source` are decided and without problem; `paint` is
/// that of the particles where the material's is `painted`.
///
/// Frees the columns that the rules do not need before it allocates. Throws InputError "FILE:
/// problem: remedy" when spheres or distinct materials are more than limits.h allows; `scene` is
/// then of no use.
void append_spheres(Particles particles, const ParticlePaint& paint, const ParticleSource& source,
                    const MaterialNames& materials, Scene& scene, int threads = 1);

}  // namespace parray::input
