#pragma once

#include <span>
#include <string>
#include <string_view>

#include "cli/input/select/expression.h"

namespace parray::input {

/// Longest text of a selection, in bytes, and its deepest nesting.
inline constexpr std::size_t max_selection_bytes = std::size_t{1} << 20;
inline constexpr std::size_t max_selection_depth = 64;

/// Reads a selection; scenes/README.md has the language. The result is a condition.
///
/// Throws InputError "column N: problem: remedy"; N counts characters from 1.
Expression parse_selection(std::string_view text);

/// Words that are a condition by themselves: "water", "protein", ...
std::span<const std::string_view> selection_classes();

/// A condition on the class `word`, one of selection_classes().
Expression class_condition(std::string_view word, std::size_t column = 1);

}  // namespace parray::input
