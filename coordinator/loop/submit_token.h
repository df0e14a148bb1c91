#pragma once

#include <algorithm>
#include <string>
#include <string_view>

#include "common/rooms.h"

namespace parray::coordinator {

/// Returns the name in a submit's token, which is NAME or NAME#DIGEST. The name identifies the job,
/// so that a repeated submit makes no second job. The digest of the submitted content shows if
/// another content has the same name.
inline std::string name_in_token(std::string_view token) {
  return std::string(token.substr(0, std::min(token.find('#'), token.size())));
}

/// Returns whether two tokens with the same name may stand for the same content. A token without a
/// digest may stand for any content.
inline bool may_be_same_content(std::string_view a, std::string_view b) {
  const bool both = a.find('#') != std::string_view::npos && b.find('#') != std::string_view::npos;
  return !both || a == b;
}

}  // namespace parray::coordinator
