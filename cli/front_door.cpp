#include "cli/front_door.h"

#include <algorithm>
#include <exception>
#include <iostream>
#include <new>
#include <nlohmann/json.hpp>

#include "cli/interrupt.h"
#include "common/base/error.h"

namespace parray {

int fail(const char* program, int status, std::string message) {
  std::replace(message.begin(), message.end(), '\n', ' ');
  // In one piece: mpirun, for one, mixes what comes in parts with the output of others.
  std::cerr << std::string(program) + ": " + message + "\n" << std::flush;
  return status;
}

int checked_output(const char* program, int status) {
  std::cout.flush();
  return std::cout || status != 0 ? status : fail(program, 1, "writing to standard output failed");
}

int run_action(const char* program, const std::function<int()>& action) {
  try {
    return checked_output(program, action());
  } catch (const InputError& error) {
    return fail(program, 2, error.what());
  } catch (const RunError& error) {
    return fail(program, 1, error.what());
  } catch (const Interrupted& interrupted) {
    return fail(program, interrupted_status, interrupted.what());
  } catch (const std::bad_alloc&) {
    return fail(program, 1, "out of memory");
  } catch (const nlohmann::json::exception& error) {
    return fail(program, 1, std::string("reading the coordinator's answer: ") + error.what());
  } catch (const std::exception& error) {
    return fail(program, 1, std::string("internal error: ") + error.what());
  }
}

}  // namespace parray
