#include <doctest/doctest.h>

#include "cli/scene_sandbox/upload_jobs.h"
#include "common/base/error.h"
#include "tests/support/rooms.h"

namespace parray::scene_sandbox {

TEST_CASE("frames are all, one, or a range with its last frame and a step") {
  CHECK_FALSE(chosen_frames_from("all").range.has_value());
  const auto range = [](const char* text) { return chosen_frames_from(text).range.value(); };
  CHECK((range("7").first == 7 && range("7").count() == 1));
  CHECK((range("0:100").last == 100 && range("0:100").count() == 101));
  CHECK((range("2:11:4").count() == 3 && range("2:11:4").number(2) == 10));
  for (const char* bad :
       {"", "-1", "1-3", "a", "3:1", "0:9:0", "0:9:1:1", ":", "all:3", "0:99999", "99999999999"}) {
    CHECK_THROWS_AS(chosen_frames_from(bad), InputError);
  }
}

}  // namespace parray::scene_sandbox
