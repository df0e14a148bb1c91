#pragma once

#include <string>
#include <utility>

#include "common/base/error.h"

namespace parray::input {

/// A member of an item of `particles` asks for what its file cannot give. The text says what, not
/// where: whoever knows the scene file or the option adds that.
class SourceError : public InputError {
 public:
  SourceError(std::string key, const std::string& problem)
      : InputError(problem), key_(std::move(key)) {}

  /// "select", "color_by": the member's key in a scene file.
  [[nodiscard]] const std::string& key() const { return key_; }

 private:
  std::string key_;
};

}  // namespace parray::input
