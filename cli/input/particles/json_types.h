#pragma once

#include <nlohmann/json.hpp>
#include <optional>

#include "common/math/vec.h"

/// Vectors and colours are lists of three numbers in JSON; a missing value is null.
template <>
struct nlohmann::adl_serializer<parray::math::Vec3d> {
  static void to_json(auto& list, const parray::math::Vec3d& v) { list = {v.x, v.y, v.z}; }
  static void from_json(const auto& list, parray::math::Vec3d& v) {
    v = {list.at(0), list.at(1), list.at(2)};
  }
};
template <typename T>
struct nlohmann::adl_serializer<std::optional<T>> {
  static void to_json(auto& to, const std::optional<T>& value) {
    if (value) to = *value;
  }
  static void from_json(const auto& from, std::optional<T>& value) {
    if (!from.is_null()) value = from.template get<T>();
  }
};
