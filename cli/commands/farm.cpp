#include "cli/commands/farm.h"

#include "cli/interrupt.h"
#include "proto/zmq_link.h"

namespace parray {

void FarmOptions::add_to(CLI::App& command) {
  command.add_option("--coordinator", address_, "Where parray-coordinator listens")
      ->type_name("ADDRESS")
      ->envname("PARRAY_COORDINATOR")
      ->capture_default_str();
}

FarmClient::FarmClient(const std::string& address)
    // Nothing is worth lingering for: every request has had its answer, or has been given up.
    : link_(zmq_connect(address, default_max_message_bytes, Time(0))),
      client_(*link_, clock_, {.address = address, .poll = check_interrupted}) {}

}  // namespace parray
