// When previews are written, in virtual time, and what is in them.
#include "cli/output/preview.h"

#include <doctest/doctest.h>

#include <algorithm>

#include "cli/output/picture/image_file.h"
#include "tests/support/dice.h"
#include "tests/support/rooms.h"
#include "tests/support/temporary_directory.h"
#include "tests/support/window_rig.h"

namespace parray::test {
namespace {

TEST_CASE("the first preview waits for a sample of every pixel, but at most a tenth of a second") {
  const PreviewPace fresh;
  CHECK_FALSE(fresh.due(0, false));
  CHECK(fresh.due(0, true));
  CHECK_FALSE(fresh.due(0.09, false));
  CHECK(fresh.due(0.11, false));
}

TEST_CASE("a complete preview follows an incomplete one as soon as possible") {
  PreviewPace pace;
  pace.wrote(0.15, false, 0.05);
  CHECK_FALSE(pace.due(0.2, false));
  CHECK(pace.due(0.2, true));
  pace.wrote(0.25, true, 0.05);
  CHECK_FALSE(pace.due(0.3, true));
}

TEST_CASE("after the first two, previews take a fiftieth of the time, at most ten per second") {
  Dice dice(5);
  for (int trial = 0; trial < 200; ++trial) {
    CAPTURE(trial);
    const double typical = dice.ten_to(-5, 1);
    PreviewPace pace;
    double elapsed = 0;
    double free = 0;  // what the first, and the first of all pixels, took
    double spent = 0;
    double largest = 0;
    int written = 0;
    bool whole_shown = false;
    const double whole_at = dice.ten_to(-3, 0.5);
    while (elapsed < 1000 * typical || elapsed < 10) {
      const bool whole = elapsed >= whole_at;
      if (!pace.due(elapsed, whole)) {
        elapsed += std::max(0.002, elapsed / 50);
        continue;
      }
      const double cost = typical * dice.between(0.5, 2);
      const bool is_free = written == 0 || (whole && !whole_shown);
      elapsed += cost;
      pace.wrote(elapsed, whole, cost);
      ++written;
      whole_shown = whole_shown || whole;
      spent += cost;
      largest = std::max(largest, cost);
      free += is_free ? cost : 0;
      // What the latest took is known afterwards only.
      CHECK(spent <= free + 0.02 * elapsed + largest);
      CHECK(written <= 3 + 10 * elapsed);
    }
    CHECK(spent <= free + 0.02 * elapsed + largest);
    CHECK(spent >= 0.01 * std::min(elapsed, 10 * typical * elapsed));
  }
}

TEST_CASE(
    "a preview of an incomplete picture can be read, has all pixels and is marked as partial") {
  const TemporaryDirectory directory;
  const auto file = directory.path() / "preview.png";
  ProgressOptions following;
  following.preview = file.string();
  Preview preview(following, [] {});
  ManualClock clock;
  JobStatus status;
  status.state = "running";
  const auto partial = [] { return Image{3, 2, std::vector<float>(18, 0.5F)}; };
  clock.go_on(seconds(5));
  preview.follow(clock, status, partial);
  CHECK_FALSE(std::filesystem::exists(file));  // nothing has been traced
  status.samples_per_second = 1;
  preview.follow(clock, status, partial);
  CHECK_FALSE(std::filesystem::exists(file));  // all pixels may have a sample soon
  clock.go_on(milliseconds(200));
  preview.follow(clock, status, partial);
  const ImageFile written = read_image(file);
  CHECK(written.image.width == 3);
  CHECK(written.image.height == 2);
  CHECK(written.image.rgb.size() == 18);
  CHECK(text_in(written.metadata, "parray:partial") == "true");
  std::filesystem::remove(file);
  preview.follow(clock, status, partial);
  CHECK_FALSE(std::filesystem::exists(file));
  status.whole = true;  // the first of all pixels is written at once
  preview.follow(clock, status, partial);
  CHECK(std::filesystem::exists(file));
}

}  // namespace
}  // namespace parray::test
