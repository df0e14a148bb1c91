#include "cli/output/frame_names.h"

#include <doctest/doctest.h>

#include <string>

#include "common/base/error.h"
#include "common/scene/limits.h"
#include "tests/support/message_of.h"
#include "tests/support/rooms.h"

namespace parray::test {

TEST_CASE("frames are a number, a range, or a range with a step") {
  CHECK(frame_range_from("7").count() == 1);
  CHECK(frame_range_from("7").number(0) == 7);
  CHECK(frame_range_from("3-5").count() == 3);
  const FrameRange range = frame_range_from("0-11:5");
  CHECK(range.count() == 3);
  CHECK(range.number(2) == 10);
  CHECK(frame_range_from("0-9999").count() == 10'000);
  for (const char* bad : {"", "a", "5-3", "-3", "1-", "1-5:", "1-5:0", "1-5:2x", "1,2", "+1-2",
                          "0-10000", "0-1000000000", "99999999999"}) {
    CAPTURE(bad);
    CHECK(message_of<InputError>([&] { frame_range_from(bad); }) != "no error");
  }
}

TEST_CASE("FRAME:STEP is refused with the right forms, because a film reads it as FIRST:LAST") {
  for (const char* text : {"0:2", "7:1", "0:"}) {
    CHECK(message_of<InputError>([&] { frame_range_from(text); }) ==
          "'" + std::string(text) +
              "' is not a range of frames: write FRAME, FIRST-LAST or FIRST-LAST:STEP with numbers "
              "up to " +
              std::to_string(limits::max_frame));
  }
  CHECK(chosen_frames_from("0:2").range.value().count() == 3);
}

TEST_CASE("a frame's number stands where the name has its signs, with as many digits at least") {
  CHECK(with_frame_number("a-####.exr", 7) == "a-0007.exr");
  CHECK(with_frame_number("a-##.exr", 1234) == "a-1234.exr");
  CHECK(with_frame_number("#/a-##.exr", 5) == "5/a-05.exr");
  CHECK(with_frame_number("a.exr", 5) == "a.exr");
  CHECK(has_frame_number("a-#.exr"));
  CHECK_FALSE(has_frame_number("a.exr"));
}

}  // namespace parray::test
