#pragma once

#include <algorithm>
#include <string>
#include <string_view>

#include "common/rooms.h"

namespace parray::coordinator {

/// A submit's token is a name, or NAME#DIGEST. The name is the job's, so that a repeated submit
/// makes no second job; the digest is of what is submitted, so that another content under the same
/// name is noticed.
inline std::string name_in_token(std::string_view token) {
  return std::string(token.substr(0, std::min(token.find('#'), token.size())));
}

/// Whether two tokens of one name may stand for the same content. One without a digest may stand
/// for any.
inline bool may_be_same_content(std::string_view a, std::string_view b) {
  const bool both = a.find('#') != std::string_view::npos && b.find('#') != std::string_view::npos;
  return !both || a == b;
}

}  // namespace parray::coordinator
