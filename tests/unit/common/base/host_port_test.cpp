#include "common/base/host_port.h"

#include <doctest/doctest.h>

#include <string>

#include "tests/support/rooms.h"

namespace parray {

TEST_CASE("a host is a name, a number, or an IPv6 address in brackets") {
  for (const std::string host : {"localhost", "127.0.0.1", "node-1.example"}) {
    const auto parsed = parse_host_port(host + ":7480");
    REQUIRE(parsed);
    CHECK(parsed->host == host);
    CHECK(parsed->port == 7480);
  }
  const auto parsed = parse_host_port("[fe80::1]:0");
  REQUIRE(parsed);
  CHECK(parsed->host == "fe80::1");
  CHECK(parsed->port == 0);
}

TEST_CASE("addresses with stray colons, brackets or signs, or without host or port, are refused") {
  for (const std::string text : {"",
                                 "localhost",
                                 ":80",
                                 "[]:80",
                                 "localhost:",
                                 "localhost:65536",
                                 "localhost:-1",
                                 "localhost:80x",
                                 "a:b:80",
                                 "::1:80",
                                 "http://localhost:80",
                                 "tcp://127.0.0.1:80",
                                 "[::1]",
                                 "[::1:80",
                                 "[:80",
                                 "]:80",
                                 "a]:80",
                                 "[[::1]]:80",
                                 "localhost:-0",
                                 "localhost:+1"}) {
    CAPTURE(text);
    CHECK_FALSE(parse_host_port(text));
  }
}

}  // namespace parray
