#pragma once

#include <filesystem>
#include <memory>
#include <string>

#include "cli/farm/client.h"
#include "common/process/command_line.h"

namespace parray::commands {

/// The coordinator that a client command talks to.
struct FarmOptions {
  /// Declares --coordinator and --keys. `needed`: the option that must be given with any of them;
  /// null: none. Ends the section of `command`: see Command::section().
  void add_to(Command& command, const Option* needed = nullptr);

  /// One or more addresses, "tcp://HOST:PORT", separated by commas.
  std::string address = "tcp://127.0.0.1:7400";
  std::string keys;  ///< key file, or directory with an administrator's key; empty: no key

  /// Returns the file with the key. Empty: no key.
  [[nodiscard]] std::filesystem::path key_file() const;
};

/// A client of the coordinator of FarmOptions, over ZeroMQ. After the user's interrupt, a request
/// that waits throws Interrupted.
class FarmClient {
 public:
  /// Throws InputError for a wrong address or key. Does not wait for the coordinator.
  explicit FarmClient(const FarmOptions& farm);

  Client& operator*() { return client_; }
  Client* operator->() { return &client_; }

 private:
  std::unique_ptr<Link> link_;
  SteadyClock clock_;
  Client client_;
};

}  // namespace parray::commands
