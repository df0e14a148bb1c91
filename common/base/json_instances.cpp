/// Compiles the functions that read and write JSON once. cmake/precompiled.h declares them as
/// `extern`, so that other sources do not compile them again.
#include <cstdint>
#include <nlohmann/json.hpp>
#include <string>

namespace {

using nlohmann::json;
using Text = nlohmann::detail::iterator_input_adapter<std::string::const_iterator>;

}  // namespace

template class nlohmann::detail::serializer<json>;
template class nlohmann::detail::lexer<json, Text>;
template class nlohmann::detail::parser<json, Text>;
template class nlohmann::detail::binary_writer<json, std::uint8_t>;
