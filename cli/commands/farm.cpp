#include "cli/commands/farm.h"

#include <iostream>
#include <optional>

#include "cli/commands/options.h"
#include "common/process/stop_signal.h"
#include "proto/address_list.h"
#include "proto/zmq_link.h"

namespace parray::commands {

void FarmOptions::add_to(Command& command, const Option* needed) {
  command.section(farm_group);
  Option coordinator =
      command.option("--coordinator", address,
                     "Address of the coordinator, and of its standbys, separated by commas");
  coordinator.type_name("ADDRESS").environment("PARRAY_COORDINATOR").show_default();
  Option key =
      command.option("--keys", keys,
                     "File with your key, such as ann.key, if the coordinator requires keys. In a "
                     "directory, ParRay uses admin.key");
  key.type_name("FILE").completes(Completes::files).environment("PARRAY_KEYS");
  command.section("");
  if (needed == nullptr) return;
  coordinator.needs(*needed);
  key.needs(*needed);
}

static constexpr const char* own_name = "admin";  // of a key in a directory

std::filesystem::path FarmOptions::key_file() const { return member_key_file(keys, own_name); }

static std::optional<MemberKey> key_of(const FarmOptions& farm) {
  return farm.keys.empty() ? std::nullopt : std::optional(read_member_key(farm.keys, own_name));
}

FarmClient::FarmClient(const FarmOptions& farm)
    // No linger time: when the client ends, it has the answers to its requests or has given up.
    : link_(zmq_connect(farm.address, max_answer_bytes, Time(0), key_of(farm))),
      client_(*link_, clock_,
              {.address = farm.address,
               .silence_hint = farm.keys.empty() ? " (or it requires a key: --keys)"
                                                 : " (or it does not know the key in --keys)",
               // Ten seconds for each address of a list.
               .timeout = seconds(10) * AddressList(farm.address).all().size(),
               .poll = check_interrupted,
               .on_silence = [](const std::string& text) {
                 std::cerr << "parray: " + text + " Waiting.\n";
               }}) {}

}  // namespace parray::commands
