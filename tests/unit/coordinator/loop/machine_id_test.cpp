#include "coordinator/loop/machine_id.h"

#include <doctest/doctest.h>

#include "tests/support/rooms.h"

namespace parray {
namespace {

Sender by_key(const std::string& key, const std::string& address) {
  return {Role::worker, key, 1, address};
}

Sender by_address(const std::string& address) { return {Role::any, "", 1, address}; }

}  // namespace

TEST_CASE("a machine's own key identifies it, whatever its address and its worker's name") {
  const MachineId node = machine_of(by_key("node-1", "10.0.0.1"), "ann");
  CHECK(node == machine_of(by_key("node-1", "10.0.0.2"), "bob"));
  CHECK(node != machine_of(by_key("node-2", "10.0.0.1"), "ann"));
  CHECK(text_of(node) == "key node-1");
}

TEST_CASE("addresses distinguish machines that share worker.key or have no key") {
  const MachineId shared = machine_of(by_key(shared_worker_key, "10.0.0.1"), "ann");
  CHECK(shared == machine_of(by_key(shared_worker_key, "10.0.0.1"), "bob"));
  CHECK(shared != machine_of(by_key(shared_worker_key, "10.0.0.2"), "ann"));
  CHECK(shared == machine_of(by_address("10.0.0.1"), "cid"));
  CHECK(text_of(shared) == "address 10.0.0.1");
}

TEST_CASE("a key and an address with the same name are different machines") {
  CHECK(machine_of(by_key("10.0.0.1", "10.0.0.9"), "ann") !=
        machine_of(by_address("10.0.0.1"), "ann"));
}

TEST_CASE("different notations of an address are the same machine") {
  CHECK(machine_of(by_address("127.0.0.1"), "a") == machine_of(by_address("127.9.9.9"), "b"));
  CHECK(machine_of(by_address("127.0.0.1"), "a") == machine_of(by_address("::1"), "b"));
  CHECK(machine_of(by_address("127.0.0.1"), "a") == machine_of(by_address("localhost"), "b"));
  CHECK(machine_of(by_address("::ffff:10.0.0.1"), "a") == machine_of(by_address("10.0.0.1"), "b"));
  CHECK(machine_of(by_address("10.0.0.1"), "a") != machine_of(by_address("10.0.0.10"), "a"));
}

TEST_CASE("a worker inside the coordinator's process is a machine of its own") {
  CHECK(machine_of(Sender{}, "ann") != machine_of(Sender{}, "bob"));
  CHECK(machine_of(Sender{}, "ann") != machine_of(by_address("ann"), "ann"));
  CHECK(text_of(machine_of(Sender{}, "ann")) == "worker ann");
}

}  // namespace parray
