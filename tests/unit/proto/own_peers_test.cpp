#include "proto/own_peers.h"

#include <arpa/inet.h>
#include <doctest/doctest.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>

#include <csignal>

#include "tests/support/rooms.h"

namespace parray {
namespace {

/// Both ends of a loopback connection. The other end may be made by another user.
struct Connection {
  explicit Connection(uid_t user = geteuid()) {
    const int door = socket(AF_INET, SOCK_STREAM, 0);
    sockaddr_in at{};
    at.sin_family = AF_INET;
    at.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    socklen_t size = sizeof at;
    REQUIRE(bind(door, reinterpret_cast<sockaddr*>(&at), sizeof at) == 0);
    REQUIRE(listen(door, 1) == 0);
    REQUIRE(getsockname(door, reinterpret_cast<sockaddr*>(&at), &size) == 0);
    child = fork();
    if (child == 0) {
      if (user != geteuid() && setuid(user) != 0) _exit(1);
      const int other = socket(AF_INET, SOCK_STREAM, 0);
      if (connect(other, reinterpret_cast<sockaddr*>(&at), sizeof at) != 0) _exit(1);
      pause();
      _exit(0);
    }
    accepted = accept(door, nullptr, nullptr);
    close(door);
  }
  ~Connection() {
    kill(child, SIGKILL);
    waitpid(child, nullptr, 0);
    close(accepted);
  }
  Connection& operator=(Connection&&) = delete;

  pid_t child = 0;
  int accepted = -1;
};

}  // namespace

TEST_CASE("a process of this user on this machine is ours, at every question") {
  const Connection connection;
  OwnPeers peers;
  CHECK(peers.has(connection.accepted));
  CHECK(peers.has(connection.accepted));
}

TEST_CASE("a process of another user on this machine is not ours") {
  if (geteuid() != 0) {
    MESSAGE("needs root");
    return;
  }
  const Connection connection(65534);
  OwnPeers peers;
  CHECK_FALSE(peers.has(connection.accepted));
}

TEST_CASE("a socket without a connection is not ours") {
  OwnPeers peers;
  CHECK_FALSE(peers.has(-1));
  const int door = socket(AF_INET, SOCK_STREAM, 0);
  CHECK_FALSE(peers.has(door));
  close(door);
}

TEST_CASE("a socket file reveals the user of its peer") {
  int ends[2] = {};
  REQUIRE(socketpair(AF_UNIX, SOCK_STREAM, 0, ends) == 0);
  OwnPeers peers;
  CHECK(peers.has(ends[0]));
  close(ends[0]);
  close(ends[1]);
}

}  // namespace parray
