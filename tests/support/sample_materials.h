#pragma once

#include "common/scene/scene.h"
#include "tests/support/rooms.h"

namespace parray::test {

inline Material diffuse(double albedo) {
  return {MaterialType::diffuse, {albedo, albedo, albedo}, 0, 1};
}
inline Material metal(double fuzz) { return {MaterialType::metal, {1, 1, 1}, fuzz, 1}; }
inline Material glass(double ior) { return {MaterialType::dielectric, {1, 1, 1}, 0, ior}; }

}  // namespace parray::test
