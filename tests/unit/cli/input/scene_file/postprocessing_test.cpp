#include "cli/input/scene_file/postprocessing.h"

#include <doctest/doctest.h>

#include <sstream>
#include <string>

#include "cli/input/scene_file/scene_file.h"
#include "cli/input/view/style.h"
#include "common/base/error.h"
#include "tests/support/message_of.h"
#include "tests/support/rooms.h"
#include "tests/support/scene_text.h"

/// What scene files say of style and finishing.
namespace parray {
namespace {

using test::message_of;
using test::read_scene_text;

using Unit = LineWidth::Unit;

/// A scene with these members beside those that it needs.
SceneFile scene_with(const std::string& members) {
  return read_scene_text(R"({"version": 1, )" + members + (members.empty() ? "" : ", ") +
                         R"("camera": {"look_from": [0,0,9], "look_at": [0,0,0], "vfov": 20},
                            "materials": {}, "spheres": []})");
}

Postprocessing finish_in(const std::string& members) { return scene_with(members).postprocessing; }

std::string refusal_of(const std::string& members) {
  return message_of<InputError>([&] { (void)scene_with(members); });
}

}  // namespace

TEST_CASE("a scene without style and finishing has neither, and the usual sky") {
  const SceneFile plain = scene_with("");
  CHECK(plain.postprocessing == Postprocessing{});
  CHECK(plain.scene.sky == Sky{});
  std::stringstream text;
  write_scene(text, plain, [] {});
  CHECK(text.str().find("finishing") == std::string::npos);
}

TEST_CASE("a style sets the sky and the postprocessing that the scene does not name") {
  const SceneFile flat = scene_with(R"("style": "flat")");
  CHECK(flat.scene.sky == sky_of(Style::flat));
  CHECK(flat.postprocessing == Postprocessing{{Unit::automatic, 0}, 0});
  const SceneFile own = scene_with(
      R"("sky": {"horizon": [0,0,1]}, "finishing": {"outline": false}, "style": "flat")");
  CHECK(own.scene.sky.horizon == Vec3d{0, 0, 1});
  CHECK(own.postprocessing == Postprocessing{});
  CHECK(scene_with(R"("style": "studio")").postprocessing == Postprocessing{});
  CHECK(scene_with(R"("style": "publication")").scene.sky.zenith == Vec3d{1, 1, 1});
}

TEST_CASE("widths and shares are numbers, words or switches") {
  CHECK(finish_in(R"("finishing": {})") == Postprocessing{});
  CHECK(finish_in(R"("finishing": {"outline": true})").outline == LineWidth{Unit::automatic, 0});
  CHECK(finish_in(R"("finishing": {"outline": 2.5})").outline == LineWidth{Unit::pixels, 2.5});
  CHECK(finish_in(R"("finishing": {"outline": "0.5pt"})").outline == LineWidth{Unit::points, 0.5});
  CHECK(finish_in(R"("finishing": {"depth_cue": 0.25})").depth_cue == 0.25);
  CHECK(finish_in(R"("finishing": {"depth_cue": true})").depth_cue == usual_depth_cue);
  CHECK(line_width_from("3") == LineWidth{Unit::pixels, 3});
  CHECK(line_width_from("off") == LineWidth{});
  CHECK(depth_cue_from("1") == 1);
}

TEST_CASE("the postprocessing of a scene is written so that it reads back equal") {
  for (const Postprocessing& postprocessing :
       {Postprocessing{{Unit::automatic, 0}, 0}, Postprocessing{{Unit::pixels, 1.5}, 0.6},
        Postprocessing{{Unit::points, 0.25}, 1}, Postprocessing{{}, 0.125}}) {
    SceneFile scene = scene_with("");
    scene.postprocessing = postprocessing;
    std::stringstream text;
    write_scene(text, scene, [] {});
    CAPTURE(text.str());
    CHECK(read_scene(text, "s.json").postprocessing == postprocessing);
  }
}

TEST_CASE("unknown styles, words and keys are refused in one line with the nearest one") {
  CHECK(refusal_of(R"("style": "publicaton")") ==
        "s.json:1: /style: unknown style 'publicaton': did you mean 'publication'?");
  CHECK(refusal_of(R"("style": "night")")
            .starts_with("s.json:1: /style: night works only with a particle file"));
  CHECK(refusal_of(R"("finishing": {"outlines": 2})").find("did you mean 'outline'?") !=
        std::string::npos);
  CHECK(refusal_of(R"("finishing": {"outline": "onn"})") ==
        "s.json:1: /finishing/outline: 'onn' is not a valid value: did you mean 'on'?");
  CHECK(refusal_of(R"("finishing": {"outline": 0})").starts_with("s.json:1: /finishing/outline: "));
  CHECK(refusal_of(R"("finishing": {"depth_cue": 1.5})").find("/finishing/depth_cue") !=
        std::string::npos);
  CHECK(message_of<InputError>([] { (void)line_width_from("wide"); }) ==
        "'wide' is not a valid value: write on, off or pixels from 0.1 to 100, or points, such as "
        "0.5pt");
  CHECK(message_of<InputError>([] { (void)depth_cue_from("2"); }) ==
        "'2' is not a valid value: write on, off or a share from 0 to 1");
}

}  // namespace parray
