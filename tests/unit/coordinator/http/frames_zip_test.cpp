#include "coordinator/http/frames_zip.h"

#include <doctest/doctest.h>

#include <fstream>

#include "common/base/error.h"
#include "coordinator/http/metrics.h"
#include "tests/support/rooms.h"
#include "tests/support/temporary_directory.h"

namespace parray::http {
namespace {

TEST_CASE("a zip stream opens a file when its turn comes, and ends at a file that fails") {
  const test::TemporaryDirectory directory;
  Budget disk(1000);
  int opened = 0;
  const auto open = [&] {
    const auto file = directory.path() / "file";
    std::ofstream(file) << "abc";
    ++opened;
    return std::make_shared<const FileBody>(file, disk);
  };
  const auto fail = []() -> std::shared_ptr<const FileBody> { throw RunError("gone"); };
  ZipStream stream(std::vector<ZipStream::Member>{{"a", open}, {"b", open}, {"c", fail}});
  CHECK(opened == 0);
  CHECK(stream.next()->ends_with("a"));
  CHECK(opened == 1);
  CHECK(stream.next() == "abc");
  CHECK(stream.next()->starts_with("PK\x03\x04"));
  CHECK_THROWS_AS(disk.hold(998, Time(0), "more"), Problem);
  CHECK_NOTHROW(disk.hold(997, Time(0), "the rest"));  // the first file is gone
  CHECK(stream.next() == "abc");
  CHECK_THROWS_AS(stream.next(), RunError);
}

TEST_CASE("requests are counted by their status") {
  RequestCounts counts;
  for (const int status : {200, 404, 200, 99, 600, -1}) counts.add(status);
  const std::string text = counts.metrics();
  CHECK(text.find("parray_http_requests_total{status=\"200\"} 2\n") != std::string::npos);
  CHECK(text.find("parray_http_requests_total{status=\"404\"} 1\n") != std::string::npos);
  CHECK(text.find("status=\"99\"") == std::string::npos);
}

}  // namespace
}  // namespace parray::http
