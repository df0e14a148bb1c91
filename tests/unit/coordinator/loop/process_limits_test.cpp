#include "coordinator/loop/process_limits.h"

#include <doctest/doctest.h>
#include <fcntl.h>
#include <spdlog/sinks/ostream_sink.h>
#include <unistd.h>

#include <algorithm>
#include <memory>
#include <sstream>
#include <string>

#include "tests/support/rooms.h"

namespace parray {
namespace {

/// A watch and the lines that it has logged.
struct Watched {
  std::ostringstream text;
  spdlog::logger log{"watch", std::make_shared<spdlog::sinks::ostream_sink_mt>(text)};
  DescriptorWatch watch{log};

  [[nodiscard]] std::ptrdiff_t lines() const {
    const std::string all = text.str();
    return std::count(all.begin(), all.end(), '\n');
  }
};

}  // namespace

TEST_CASE("the watch warns once when nine tenths of the open files are in use") {
  Watched w;
  w.watch.check({900, 1000});
  CHECK(w.lines() == 0);
  w.watch.check({901, 1000});
  w.watch.check({999, 1000});
  CHECK(w.lines() == 1);
  CHECK(w.text.str().find("901 of 1000 open files are in use") != std::string::npos);
  CHECK(w.text.str().find("ulimit -n") != std::string::npos);
}

TEST_CASE("the watch reports once that connections work again, and can warn again afterwards") {
  Watched w;
  w.watch.check({950, 1000});
  w.watch.check({850, 1000});  // no message: the two thresholds differ
  CHECK(w.lines() == 1);
  w.watch.check({799, 1000});
  w.watch.check({100, 1000});
  CHECK(w.lines() == 2);
  CHECK(w.text.str().find("new connections work again") != std::string::npos);
  w.watch.check({950, 1000});
  CHECK(w.lines() == 3);
}

TEST_CASE("the number of open files grows by one with each file that is opened") {
  const DescriptorUse before = descriptor_use();
  const int file = open("/dev/null", O_RDONLY | O_CLOEXEC);
  REQUIRE(file >= 0);
  CHECK(descriptor_use().open == before.open + 1);
  CHECK(descriptor_use().most >= descriptor_use().open);
  close(file);
  CHECK(descriptor_use().open == before.open);
}

}  // namespace parray
