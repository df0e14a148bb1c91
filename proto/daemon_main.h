#pragma once

#include <CLI/CLI.hpp>
#include <exception>
#include <functional>
#include <iostream>
#include <string>

#include "common/base/error.h"
#include "common/base/stop_signal.h"

namespace parray {

/// What the main() of every daemon does around its work: parses the command line, catches stop
/// signals, runs `work`, and turns an error into one line on stderr and the exit status of
/// README.md (0 done, 1 failed, 2 bad usage or bad input).
inline int daemon_main(CLI::App& app, int argc, char** argv, const std::function<int()>& work) {
  const auto fail = [&](int status, const std::string& message) {
    std::cerr << app.get_name() << ": " << message << std::endl;
    return status;
  };
  try {
    app.parse(argc, argv);
    catch_stop_signals();
    return work();
  } catch (const CLI::Success& asked) {  // --help, --version
    return app.exit(asked);
  } catch (const CLI::ParseError& error) {
    return fail(2, std::string(error.what()) + "; see " + app.get_name() + " --help");
  } catch (const InputError& error) {
    return fail(2, error.what());
  } catch (const std::exception& error) {
    return fail(1, error.what());
  }
}

}  // namespace parray
