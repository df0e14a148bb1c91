#pragma once

#include <string>

#include "tests/support/rooms.h"

namespace parray::test {

/// Returns the message of the Error that `function` throws, or "no error". Any other exception
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
