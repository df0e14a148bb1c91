#pragma once

#include <string>
#include <string_view>

#include "common/rooms.h"

namespace parray::input {

/// nlohmann's description of a syntax error as one of ours: "not JSON (REASON): REMEDY".
///
/// `what`: its message, "[...] parse error at ...: syntax error while parsing X - REASON[; last
/// read: 'TOKEN'][; expected Y]". `last_token`: the text that the lexer had read by then, any
/// bytes.
std::string describe_syntax_error(std::string_view what, std::string_view last_token);

}  // namespace parray::input
