#include <CLI/CLI.hpp>
#include <algorithm>
#include <exception>
#include <iostream>
#include <new>
#include <nlohmann/json.hpp>
#include <string>

#include "cli/commands/commands.h"
#include "cli/interrupt.h"
#include "cli/usage_error.h"
#include "common/base/error.h"

namespace {

constexpr const char* about = "ParRay renders scenes of spheres, on this machine or on many.";
constexpr const char* footer =
    "\nparray COMMAND --help lists a command's options.\n"
    "Exit status: 0 done; 1 failed; 2 bad usage or bad input; 130 interrupted.";

int fail(int status, std::string message) {
  std::replace(message.begin(), message.end(), '\n', ' ');
  std::cerr << "parray: " << message << std::endl;
  return status;
}

/// What was printed must have arrived: a full disk behind stdout is a failure, too.
int checked(int status) {
  std::cout.flush();
  return std::cout || status != 0 ? status : fail(1, "writing to standard output failed");
}

int run(const parray::Action& action) {
  try {
    return checked(action());
  } catch (const parray::InputError& error) {
    return fail(2, error.what());
  } catch (const parray::RunError& error) {
    return fail(1, error.what());
  } catch (const parray::Interrupted& interrupted) {
    return fail(parray::interrupted_status, interrupted.what());
  } catch (const std::bad_alloc&) {
    return fail(1, "out of memory");
  } catch (const nlohmann::json::exception& error) {
    return fail(1, std::string("reading the coordinator's answer: ") + error.what());
  } catch (const std::exception& error) {
    return fail(1, std::string("internal error: ") + error.what());
  }
}

int front_door(int argc, char** argv) {
  parray::install_signal_handlers();
  CLI::App app(about, "parray");
  app.footer(footer);
  app.set_version_flag("--version", "parray " PARRAY_VERSION);
  app.require_subcommand(0, 1);
  parray::Action action = [&app] {
    std::cout << app.help();
    return 0;
  };
  parray::add_commands(app, action);
  try {
    app.parse(argc, argv);
  } catch (const CLI::Success& asked) {  // --help, --version
    return checked(app.exit(asked, std::cout, std::cerr));
  } catch (const CLI::ParseError& error) {
    return fail(2, parray::usage_message(app, error));
  }
  return run(action);
}

}  // namespace

int main(int argc, char** argv) {
  try {
    return front_door(argc, argv);
  } catch (...) {  // not even the message could be made
    return 1;
  }
}
