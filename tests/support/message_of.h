#pragma once

#include <string>

#include "tests/support/rooms.h"

namespace parray::test {

/// What `function` says when it throws an Error; "no error" when it does not. Any other exception
/// passes through and fails the test.
template <typename Error, typename Function>
std::string message_of(const Function& function) {
  try {
    function();
  } catch (const Error& error) {
    return error.what();
  }
  return "no error";
}

}  // namespace parray::test
