#include "cli/commands/farm.h"

#include <iostream>

#include "common/process/stop_signal.h"
#include "proto/zmq_link.h"

namespace parray {

void FarmOptions::add_to(Command& command) {
  command.option("--coordinator", address_, "Where parray-coordinator listens")
      .type_name("ADDRESS")
      .environment("PARRAY_COORDINATOR")
      .show_default();
}

FarmClient::FarmClient(const std::string& address)
    // Nothing is worth lingering for: every request has had its answer, or has been given up.
    : link_(zmq_connect(address, default_max_message_bytes, Time(0))),
      client_(*link_, clock_,
              {.address = address,
               .poll = check_interrupted,
               .on_silence = [](const std::string& text) {
                 std::cerr << "parray: " + text + " Waiting.\n";
               }}) {}

}  // namespace parray
