#include "cli/output/recipe.h"

#include <doctest/doctest.h>

#include <functional>
#include <nlohmann/json.hpp>

#include "common/base/error.h"
#include "common/scene/settings.h"
#include "proto/messages.h"
#include "tests/support/message_of.h"
#include "tests/support/rooms.h"

namespace parray {
namespace {

using nlohmann::json;
using test::message_of;

/// As a coordinator's, of a picture of one pixel.
Picture picture_of(const json& changes = json::object()) {
  Picture picture;
  picture.image = {1, 1, {0.25F, 0.5F, 1.0F}};
  picture.report = {{"version", "1.2.3"},
                    {"trace_version", trace_version},
                    {"scene_sha256", std::string(64, 'a')},
                    {"image_sha256", image_sha256(picture.image)},
                    {"width", 1U},
                    {"height", 1U},
                    {"max_depth", 7U},
                    {"seed", 18446744073709551615U},
                    {"sampler", "sobol"},
                    {"precision", "mixed"},
                    {"samples", 48U},
                    {"samples_per_pixel", 48U},
                    {"least_samples", 48U},
                    {"most_samples", 48U},
                    {"adaptive", false},
                    {"target_half_width", 0.0},
                    {"passes", json::array()},
                    {"error", {{"rmse", 0.125}, {"low", nullptr}}}};
  picture.report.update(changes);
  return picture;
}

const json adaptive_entries = {{"adaptive", true},          {"samples_per_pixel", 40.5},
                               {"least_samples", 32U},      {"most_samples", 64U},
                               {"target_half_width", 0.03}, {"passes", {32U, 16U}}};

/// What a file of that kind gives back.
Recipe kept_recipe(const Picture& picture, bool exr) {
  return recipe_in(
      as_kept(exr ? recipe_metadata(picture) : recipe_metadata(picture, picture.image), exr),
      "a.exr");
}

/// What is said of a recipe in which one value is another.
std::string refusal(const json& changes, const std::string& name, const MetadataValue& value) {
  ImageMetadata metadata = recipe_metadata(picture_of(changes));
  std::erase_if(metadata, [&](const auto& pair) { return pair.first == "parray:" + name; });
  metadata.emplace_back("parray:" + name, value);
  return message_of<InputError>([&] { recipe_in(metadata, "a.exr"); });
}

}  // namespace

TEST_CASE("a recipe contains all values that determine the bits, in both kinds of file") {
  for (const bool exr : {true, false}) {
    const Picture picture = picture_of();
    const Recipe recipe = kept_recipe(picture, exr);
    RenderSettings expected;
    expected.width = 1;
    expected.height = 1;
    expected.max_depth = 7;
    expected.seed = 18446744073709551615U;
    expected.sampler = Sampler::sobol;
    expected.precision = Precision::mixed;
    expected.samples_per_pixel = 48;
    CHECK(recipe.settings == expected);
    CHECK(recipe.equal_samples);
    CHECK(recipe.samples == 48);
    CHECK(recipe.image_sha256 == image_sha256(picture.image));
    CHECK(recipe.scene_sha256 == std::string(64, 'a'));
    CHECK(recipe.trace_version == trace_version);
    CHECK(recipe.pixels_sha256.empty() == exr);
  }
}

TEST_CASE("for different numbers of samples, the recipe has the passes and their target") {
  for (const bool exr : {true, false}) {
    const Recipe recipe = kept_recipe(picture_of(adaptive_entries), exr);
    CHECK_FALSE(recipe.equal_samples);
    CHECK(recipe.settings->adaptive);
    CHECK(recipe.settings->passes == std::vector<std::uint64_t>{32, 16});
    CHECK(recipe.settings->target_half_width == 0.03);
  }
  // An adaptive picture that was good enough after its first pass.
  json equal = adaptive_entries;
  equal.update({{"samples_per_pixel", 32U}, {"most_samples", 32U}});
  CHECK(kept_recipe(picture_of(equal), true).settings->samples_per_pixel == 32);
}

TEST_CASE("EXR stores numbers as numbers, and unknown values are left out") {
  const ImageMetadata metadata = as_kept(recipe_metadata(picture_of()), true);
  const auto is = [&](const std::string& name, const MetadataValue& value) {
    return std::find(metadata.begin(), metadata.end(), std::pair(name, value)) != metadata.end();
  };
  CHECK(is("parray:width", std::uint64_t{1}));
  CHECK(is("parray:adaptive", std::uint64_t{0}));
  CHECK(is("parray:error:rmse", 0.125));
  CHECK(is("parray:seed", "18446744073709551615"));
  CHECK(real_in(metadata, "parray:error:low") == std::nullopt);
}

TEST_CASE("previews and pictures of other programs have no recipe") {
  const auto of = [](const ImageMetadata& metadata) {
    return message_of<InputError>([&] { recipe_in(metadata, "a.exr"); });
  };
  CHECK(of({{"parray:partial", "true"}}).starts_with("a.exr: an unfinished picture has no recipe"));
  CHECK(of({{"parray:partial", std::uint64_t{1}}})
            .starts_with("a.exr: an unfinished picture has no recipe"));
  CHECK(of({{"Software", "GIMP"}}).starts_with("a.exr: the file has no recipe"));
}

TEST_CASE("a recipe with an invalid value is refused with the name of the value") {
  for (const char* name : {"width", "max_depth", "seed", "sampler", "precision", "samples",
                           "samples_per_pixel", "image_sha256", "scene_sha256"}) {
    const std::string message = refusal(json::object(), name, -1.5);
    CHECK_MESSAGE(message.starts_with("a.exr: the recipe is damaged: "), message);
    CHECK_MESSAGE(message.find(name) != std::string::npos, message);
  }
  CHECK(refusal(json::object(), "width", std::uint64_t{70000}).find("width: 70000") !=
        std::string::npos);
  CHECK(refusal(json::object(), "width", std::uint64_t{1} << 32).find("parray:width") !=
        std::string::npos);
  CHECK(refusal(json::object(), "precision", "auto").find("parray:precision") != std::string::npos);
  for (const char* passes : {"", "1,", "[1],2", "x", "-1", "0", "1e3"}) {
    const std::string message = refusal(adaptive_entries, "passes", passes);
    CHECK_MESSAGE(message.starts_with("a.exr: the recipe is damaged: "), passes, message);
  }
  json larger = adaptive_entries;
  larger.update({{"width", 30U}, {"height", 20U}});
  CHECK(refusal(larger, "passes", "600,600") == "no error");
  const std::string invented = refusal(larger, "passes", "64");
  CHECK_MESSAGE(invented.starts_with("a.exr: the recipe is damaged: parray:passes"), invented);
}

TEST_CASE("a different scene and a different tracer are refused") {
  Recipe recipe = kept_recipe(picture_of(), true);
  const auto refused = [&](const std::string& scene_sha256) {
    return message_of<InputError>(
        [&] { check_recipe(recipe, "a.exr", scene_sha256, "scene.json"); });
  };
  CHECK(refused(std::string(64, 'a')) == "no error");
  CHECK(refused(std::string(64, 'b')).starts_with("scene.json: this is not the scene of a.exr"));
  ++recipe.trace_version;
  CHECK(refused(std::string(64, 'a')).find("use ParRay 1.2.3") != std::string::npos);
}

}  // namespace parray
