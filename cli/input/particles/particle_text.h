#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "cli/input/particles/file_place.h"

/// Words and numbers of text formats. Numbers do not depend on the locale.
namespace parray::input {

/// `text` without blanks (spaces and tabs) at its ends.
std::string_view trimmed(std::string_view text);

/// ASCII letters in lower case.
std::string lower_case(std::string_view text);

std::vector<std::string> lower_case(const std::vector<std::string_view>& texts);

/// Replaces `fields` by the words of `line`, which blanks separate. They point into `line`.
void split_at_blanks(std::string_view line, std::vector<std::string_view>& fields);

/// All of `text` as a finite number, also with a leading '+'.
std::optional<double> number_in(std::string_view text);

/// The same; NaN for anything else.
double number_or_nan(std::string_view text);

/// All of `text` as a whole number written in digits alone.
std::optional<std::uint64_t> natural_in(std::string_view text);

/// The number of a field; `what` names it. Fails at `place` when it is not one, or not finite.
double number_field(std::string_view text, std::string_view what, const FilePlace& place);

/// The number of particles that a file announces, 0 to limits::max_spheres.
std::uint64_t count_field(std::string_view text, const FilePlace& place);

}  // namespace parray::input
