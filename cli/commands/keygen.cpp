// Keys for a farm that other machines use.
#include <filesystem>
#include <iostream>
#include <memory>
#include <string>

#include "cli/commands/commands.h"
#include "proto/keys.h"

namespace parray::commands {
namespace {

namespace fs = std::filesystem;

struct KeygenCommand {
  std::string directory;
  std::string role;
  std::string name;
  std::string removed;
  std::string token_of;
  double share = 1;
};

int make_farm(const fs::path& directory) {
  make_farm_keys(directory);
  std::cout << "keys of a new farm are in " << directory.string() << ":\n"
            << "  here:          parray-coordinator --coordinator 'tcp://*:7400' --keys "
            << directory.string() << "\n"
            << "  each worker:   copy " << (directory / "worker.key").string()
            << " there; parray-worker --coordinator tcp://THIS-MACHINE:7400 --keys worker.key\n"
            << "  you:           parray submit SCENE --keys " << (directory / "admin.key").string()
            << "\n  others:        parray keygen " << directory.string()
            << " --role client --name NAME, and give them NAME.key\n";
  return 0;
}

int keygen(const KeygenCommand& command) {
  const fs::path directory = command.directory;
  if (!command.removed.empty()) {
    remove_member_key(directory, command.removed);
    remove_token(directory, command.removed);
    std::cout << "'" << command.removed << "' has no access any more\n";
    return 0;
  }
  if (!command.token_of.empty()) {
    std::cout << make_token(directory, command.token_of) << "\n";
    return 0;
  }
  if (command.name.empty()) return make_farm(directory);
  const Role role = command.role == "worker"  ? Role::worker
                    : command.role == "admin" ? Role::admin
                                              : Role::client;
  add_member_key(directory, role, command.name, command.share);
  std::cout << "give " << (directory / (command.name + ".key")).string() << " to " << name_of(role)
            << " '" << command.name << "' over a secure channel\n";
  return 0;
}

}  // namespace

void add_keygen(CommandLine& line) {
  Command command = line.command("keygen", "Make the keys of a farm, or add or remove a key");
  const auto options = std::make_shared<KeygenCommand>();
  command.option("DIR", options->directory, "Directory of the farm's keys")
      .required()
      .completes(Completes::directories);
  const Option name =
      command.option("--name", options->name, "Add a key for a person or worker: DIR/NAME.key")
          .type_name("NAME")
          .forbid_empty();
  command
      .option("--role", options->role,
              "Role of the key's owner: worker, client or admin (default: client)")
      .one_of({"worker", "client", "admin"})
      .needs(name);
  command
      .number("--share", options->share, least_share, largest_share,
              "Share of the workers' time relative to other users, when several users have jobs "
              "(default: 1)")
      .needs(name);
  Option removed =
      command.option("--remove", options->removed, "Remove the key and the HTTP token of NAME");
  removed.type_name("NAME").forbid_empty().excludes(name);
  command
      .option("--token", options->token_of,
              "Print a new HTTP token for the client or administrator NAME. An earlier token "
              "becomes invalid")
      .type_name("NAME")
      .forbid_empty()
      .excludes(name)
      .excludes(removed);
  command.example("parray keygen farm", "makes the keys of a new farm, and explains their use");
  command.example("parray keygen farm --name ann", "makes a client's key, farm/ann.key");
  command.example("parray keygen farm --name ann --share 3",
                  "gives ann three times the workers' time of others");
  command.example("parray keygen farm --token ann", "prints a token for HTTP");
  command.example("parray keygen farm --remove ann",
                  "the coordinator refuses ann from the next second on");
  command.runs([options] { return keygen(*options); });
}

}  // namespace parray::commands
