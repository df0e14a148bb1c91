#include "cli/input/color/particle_colors.h"

#include <doctest/doctest.h>

#include <array>
#include <cmath>
#include <limits>
#include <numeric>
#include <set>
#include <sstream>
#include <string>
#include <vector>

#include "cli/input/particles/elements.h"
#include "cli/input/particles/file_place.h"
#include "cli/input/particles/residues.h"
#include "cli/input/particles/selected_particles.h"
#include "cli/input/scene_file/scene_file.h"
#include "cli/input/select/selection.h"
#include "cli/input/view/auto_scene.h"
#include "cli/output/picture/partial_file.h"
#include "common/base/error.h"
#include "tests/support/dice.h"
#include "tests/support/message_of.h"
#include "tests/support/particle_columns.h"
#include "tests/support/rooms.h"
#include "tests/support/temporary_directory.h"

/// Colours of particles by what they are and by their numbers, and the keys of a scene that ask for
/// them.
namespace parray {
namespace {

using test::add_name;
using test::Dice;
using test::message_of;
using test::unknown_number;

constexpr double infinity = std::numeric_limits<double>::infinity();

Particles with_numbers(const std::vector<double>& values) {
  Particles out;
  out.positions.resize(values.size());
  out.numbers.push_back({"vx", values});
  return out;
}

ParticleColoring by_number(const std::string& range = {}, ColorMap map = ColorMap::viridis) {
  ParticleColoring out{"vx", map, {}};
  if (!range.empty()) out.range = color_range_from(range);
  return out;
}

/// Where each of the numbers stands on the map, 0 to 1; -1: it is not known.
std::vector<double> shares(const std::vector<double>& values, const ParticleColoring& coloring) {
  Particles particles = with_numbers(values);
  const ParticleColors paint = colors_of(coloring, particles);
  std::vector<double> out;
  for (const std::uint32_t level : paint.index) {
    out.push_back(level == color_levels ? -1 : level / static_cast<double>(color_levels - 1));
  }
  return out;
}

/// A scene with one item of particles, and a table beside it.
class ColoredScene {
 public:
  ColoredScene() {
    write("a.csv",
          "x,y,z,type,element,vx,q\n0,0,0,a,C,-1,0\n1,0,0,b,O,0,0.5\n2,0,0,a,C,1,nan\n"
          "3,0,0,c,H,3,1\n");
  }
  void write(const std::string& name, const std::string& text) const {
    write_text_file(directory_.path() / name, text);
  }
  [[nodiscard]] std::string path(const std::string& name) const {
    return (directory_.path() / name).string();
  }
  /// The scene with these members beside the file's.
  [[nodiscard]] SceneFile read(const std::string& members) const {
    write("s.json", R"({"version": 1,
"camera": {"look_from": [0, 0, 9], "look_at": [0, 0, 0], "vfov": 40},
"materials": {"gold": {"type": "metal", "albedo": [0.8, 0.6, 0.2], "fuzz": 0.25},
 "glass": {"type": "dielectric", "ior": 1.5}},
"particles": [{"file": "a.csv", "radius": 1,
)" + members + "}]}");
    return read_scene_file(path("s.json"));
  }
  [[nodiscard]] SceneFile expanded(const std::string& members) const {
    SceneFile file = read(members);
    expand_particles(file, path("s.json"));
    return file;
  }
  [[nodiscard]] std::string refusal(const std::string& members) const {
    const std::string message = message_of<InputError>([&] { (void)expanded(members); });
    REQUIRE(message.starts_with(path("s.json") + ":"));
    return message.substr(path("s.json").size() + 1);
  }

 private:
  test::TemporaryDirectory directory_;
};

}  // namespace

TEST_CASE("numbers are coloured between the least and the largest") {
  CHECK(shares({2, 4, 3}, by_number()) == std::vector<double>{0, 1, 0.5});
  CHECK(shares({5, 5}, by_number()) == std::vector<double>{0.5, 0.5});
  CHECK(shares({-1e308, 1e308, 0}, by_number()) == std::vector<double>{0, 1, 0.5});
  CHECK(shares({-infinity, 1, 3, infinity, unknown_number}, by_number()) ==
        std::vector<double>{0, 0, 1, 1, -1});
}

TEST_CASE("a legend of numbers has the unit of the file") {
  Particles particles = with_numbers({1, 2});
  CHECK(colors_of(by_number(), particles).legend.unit.empty());
  particles.numbers[0].unit = "m/s";
  particles.facts.length_unit = "um";
  CHECK(colors_of(by_number(), particles).legend.unit == "m/s");
  CHECK(colors_of({"z"}, particles).legend.unit == "\u00b5m");
  CHECK(colors_of({"index"}, particles).legend.unit.empty());
}

TEST_CASE("colours by index count removed particles") {
  Particles particles = with_numbers({0, 0, 0, 0, 0, 0});
  keep(particles, {0, 1, 1, 0, 0, 1});
  const ParticleColors paint = colors_of({"index"}, particles);
  CHECK(paint.legend.low == 1);
  CHECK(paint.legend.high == 5);
  keep(particles, {0, 1, 1});
  CHECK(colors_of({"index"}, particles).legend.low == 2);
}

TEST_CASE("a range clips numbers and a note counts them") {
  const std::vector<double> values{-3, -1, 0, 1, unknown_number, 2};
  CHECK(shares(values, by_number("-1:1")) == std::vector<double>{0, 0, 0.5, 1, -1, 1});
  Particles particles = with_numbers(values);
  const ParticleColors paint = colors_of(by_number("-1:1"), particles);
  REQUIRE(particles.facts.notes.size() == 2);
  CHECK(particles.facts.notes[0].key == "unknown_numbers");
  CHECK(particles.facts.notes[0].count == 1);
  CHECK(particles.facts.notes[1].key == "clipped");
  CHECK(particles.facts.notes[1].count == 2);
  CHECK(particles.facts.notes[1].text ==
        "particles whose vx is outside -1 to 1, in the colour of the nearer end");
  CHECK(paint.legend.title == "vx");
  CHECK(paint.legend.low == -1);
  CHECK(paint.legend.high == 1);
  CHECK(paint.legend.stops.size() == 65);
  CHECK(paint.legend.stops[32] == color_at(ColorMap::viridis, 0.5));
  REQUIRE(paint.legend.entries.size() == 1);
  CHECK(paint.legend.entries[0].name == "not known");
  CHECK(paint.legend.entries[0].count == 1);
}

TEST_CASE("a logarithmic scale has equal steps for equal factors, and none for numbers up to 0") {
  ParticleColoring coloring = by_number();
  coloring.scale = NumberScale::log;
  CHECK(shares({1, 100, 10, 0, -5, unknown_number}, coloring) ==
        std::vector<double>{0, 1, 0.5, -1, -1, -1});
  CHECK(shares({1e-300, 1e300, 1}, coloring) == std::vector<double>{0, 1, 0.5});
  CHECK(shares({7, 7}, coloring) == std::vector<double>{0.5, 0.5});
  Particles particles = with_numbers({1, 100, -5});
  const ParticleColors paint = colors_of(coloring, particles);
  CHECK(paint.legend.log);
  CHECK(paint.legend.low == 1);
  CHECK(paint.legend.high == 100);
  REQUIRE(particles.facts.notes.size() == 1);
  CHECK(particles.facts.notes[0].text == "particle without a positive vx, in a separate colour");
  coloring.range = color_range_from("0:");
  CHECK_THROWS_WITH_AS(shares({1, 2}, coloring),
                       "a logarithmic scale cannot begin at 0: write a low end above 0",
                       SourceError);
  coloring.range = {};
  CHECK_THROWS_WITH_AS(shares({0, -1}, coloring),
                       "no particle has a positive vx: choose another column", SourceError);
}

TEST_CASE("a logarithmic scale of one number is finite and above 0, also for extreme numbers") {
  ParticleColoring coloring = by_number();
  coloring.scale = NumberScale::log;
  for (const double value : {std::numeric_limits<double>::denorm_min(), 1e-308, 1e308,
                             std::numeric_limits<double>::max()}) {
    CAPTURE(value);
    Particles particles = with_numbers({value, value});
    const Legend legend = colors_of(coloring, particles).legend;
    CHECK(legend.low > 0);
    CHECK(legend.low < legend.high);
    CHECK(std::isfinite(legend.high));
    const double share = shares({value, value}, coloring).front();
    CHECK((share >= 0 && share <= 1));
  }
}

TEST_CASE("each number is a category, in the order of the numbers and not of the particles") {
  ParticleColoring coloring = by_number();
  coloring.scale = NumberScale::categories;
  coloring.map = {};
  Particles particles = with_numbers({30, -1.5, 30, 2, unknown_number});
  const ParticleColors paint = colors_of(coloring, particles);
  REQUIRE(paint.legend.entries.size() == 4);
  const std::array<std::string, 4> names{"-1.5", "2", "30", "no name"};
  for (std::size_t i = 0; i < names.size(); ++i) {
    CHECK(paint.legend.entries[i].name == names.at(i));
    CHECK(paint.legend.entries[i].color == category_color(i));
  }
  CHECK(paint.palette[paint.index[0]] == category_color(2));
  std::vector<double> many(1001);
  std::iota(many.begin(), many.end(), 0.0);
  Particles numbers = with_numbers(many);
  CHECK_THROWS_WITH_AS(colors_of(coloring, numbers),
                       "vx has more than 1000 different numbers: use linear or log", SourceError);
}

TEST_CASE("numbered names have the colour of their number, others that of their place in order") {
  const std::vector<Vec3d> numbered = colors_of_names({"3", "1", "24"});
  CHECK(numbered[0] == category_color(2));
  CHECK(numbered[1] == category_color(0));
  CHECK(numbered[2] == category_color(23));
  for (const std::vector<std::string>& names :
       {std::vector<std::string>{"3", "1", "25"}, {"3", "1", "4x"}, {"3", "0", "7"}}) {
    std::vector<Vec3d> expected(3);
    const std::vector<std::size_t> order = reading_order(names);
    for (std::size_t i = 0; i < order.size(); ++i) expected[order[i]] = category_color(i);
    CHECK(colors_of_names(names) == expected);
  }
}

TEST_CASE("percentiles are by nearest rank and ignore unknown numbers") {
  std::vector<double> values{unknown_number, infinity};
  for (int i = 1; i <= 100; ++i) values.push_back((i * 37) % 101);
  Particles particles = with_numbers(values);
  const Legend legend = colors_of(by_number("1%:90%"), particles).legend;
  CHECK(legend.low == 1);
  CHECK(legend.high == 90);
  CHECK(colors_of(by_number(":50%"), particles).legend.low == 1);
  CHECK(colors_of(by_number("0%:100%"), particles).legend.high == 100);
}

TEST_CASE("a diverging map has its middle at zero unless a range is given") {
  CHECK(shares({-1, 0, 4}, by_number({}, ColorMap::blue_red))[1] == 0.5);
  CHECK(shares({1, 2, 3}, by_number({}, ColorMap::blue_red)) == std::vector<double>{0, 0.5, 1});
  CHECK(shares({-1, 0, 4}, by_number("-1:4", ColorMap::blue_red))[0] == 0);
}

TEST_CASE("an invalid range is refused") {
  for (const char* text : {"", "1", "2:1", "1:1", "-1%:50%", "60%:40%", "0:101%", "a:b", "1:2:3"}) {
    CAPTURE(text);
    CHECK(message_of<InputError>([&] {
            (void)color_range_from(text);
          }).find("is not a range: write two ascending numbers") != std::string::npos);
  }
  Particles particles = with_numbers({1, 2});
  CHECK(message_of<SourceError>([&] { (void)colors_of(by_number("5:"), particles); }) ==
        "low (5) is above high (2) for these particles: give both ends as numbers, the smaller "
        "first");
  Particles nothing = with_numbers({unknown_number, infinity});
  CHECK(message_of<SourceError>([&] { (void)colors_of(by_number(), nothing); }) ==
        "no particle has a finite vx: choose another column");
  CHECK_THROWS_AS((void)colors_of({"vz", {}, {}}, particles), UnknownNumber);
}

TEST_CASE("colours by number are few and the same for any number of threads") {
  Dice dice(4);
  std::vector<double> values;
  for (int i = 0; i < 100'000; ++i) {
    values.push_back(dice.one_in(50) ? unknown_number : dice.unit());
  }
  Particles particles = with_numbers(values);
  const ParticleColors one = colors_of(by_number("5%:95%"), particles);
  CHECK(one.palette.size() == color_levels + 1);
  CHECK(one.palette.size() <= 1024);
  for (const int threads : {2, 5}) {
    const ParticleColors other = colors_of(by_number("5%:95%"), particles, threads);
    CHECK(other.index == one.index);
    CHECK(other.legend == one.legend);
  }
  CHECK(std::set<std::uint32_t>(one.index.begin(), one.index.end()).size() == color_levels + 1);
}

TEST_CASE("types keep their colours in all frames for any order of atoms") {
  Particles first;
  Particles second;
  for (const char* name : {"2", "10", "1", "X"}) add_name(first.types, name);
  for (const char* name : {"X", "1", "2", "10"}) add_name(second.types, name);
  first.positions.resize(4);
  second.positions.resize(4);
  const ParticleColors a = colors_of({"type", {}, {}}, first);
  const ParticleColors b = colors_of({"type", {}, {}}, second);
  CHECK(a.legend == b.legend);
  std::vector<std::string> names;
  for (const LegendEntry& entry : a.legend.entries) names.push_back(entry.name);
  CHECK(names == std::vector<std::string>{"1", "2", "10", "X"});
}

TEST_CASE("categories have different colours, which a selection does not change") {
  Particles particles;
  for (const char* name : {"B", "A", "B", "C", ""}) {
    add_name(particles.chains, name);
    particles.positions.push_back({});
  }
  const ParticleColors paint = colors_of({"chain", {}, {}}, particles);
  CHECK(paint.index == std::vector<std::uint32_t>{0, 1, 0, 2, 3});
  CHECK(paint.palette[0] == category_color(1));  // A comes before it, in whichever order they stand
  CHECK(paint.palette[2] == category_color(2));
  REQUIRE(paint.legend.entries.size() == 4);
  CHECK(paint.legend.title == "chain");
  CHECK(paint.legend.entries[0] == LegendEntry{"A", category_color(0), 1});
  CHECK(paint.legend.entries[3].name == "no name");
  keep(particles, {0, 1, 0, 1, 0});
  const ParticleColors some = colors_of({"chain", {}, {}}, particles);
  CHECK(some.index == std::vector<std::uint32_t>{1, 2});
  REQUIRE(some.legend.entries.size() == 2);
  CHECK(some.legend.entries[0] == LegendEntry{"A", category_color(0), 1});
  CHECK(message_of<SourceError>([&] {
          (void)colors_of({"residue", {}, {}}, particles);
        }) == "the file has no residue names: it has chains, x, y, z, fx, fy, fz, index");
}

TEST_CASE("residues are coloured by their group") {
  CHECK(residue_groups().size() == 11);
  const auto group = [](const char* name) {
    const auto number = residue_group(name);
    return number ? std::string(residue_groups()[*number]) : "none";
  };
  CHECK(group("ASP") == "negative");
  CHECK(group("lys") == "positive");
  CHECK(group("HSD") == "positive");
  CHECK(group("NALA") == "aliphatic");
  CHECK(group("CYX") == "glycine, proline, cysteine");
  CHECK(group("DA") == "adenine");
  CHECK(group("DA5") == "adenine");
  CHECK(group("RU") == "thymine, uracil");
  CHECK(group("THY") == "thymine, uracil");
  CHECK(group("HOH") == "water");
  CHECK(group("TIP3") == "water");
  CHECK(group("POPC") == "none");
  CHECK(group("") == "none");
  Particles particles;
  for (const char* name : {"POPC", "ASP", "GLU", "CHL1"}) {
    add_name(particles.residue_names, name);
    particles.positions.push_back({});
  }
  const ParticleColors paint = colors_of({"residue", {}, {}}, particles);
  CHECK(paint.index[1] == paint.index[2]);
  REQUIRE(paint.legend.entries.size() == 3);
  CHECK(paint.legend.entries[0].name == "negative");
  CHECK(paint.legend.entries[0].count == 2);
  CHECK(paint.legend.entries[1].name == "POPC");
  CHECK(paint.legend.entries[2].color == category_color(12));
}

TEST_CASE("a scene file colours, selects and slices particles") {
  const ColoredScene files;
  const SceneFile file = files.expanded(
      R"("select": "vx > -1 or type b", "slice": "x=:2.5", "color_by": "vx", "range": [0, 2],
 "colormap": "grey")");
  REQUIRE(file.scene.spheres.size() == 2);
  CHECK(file.scene.spheres[0].center == Vec3d{1, 0, 0});
  CHECK(file.scene.materials[file.scene.spheres[0].material].albedo == color_at(ColorMap::grey, 0));
  CHECK(file.scene.materials[file.scene.spheres[1].material].albedo ==
        color_at(ColorMap::grey, 0.5));
  REQUIRE(file.legends.size() == 1);
  CHECK(file.legends[0].high == 2);
}

TEST_CASE("color_by element gives the colours of the material by-element") {
  const ColoredScene files;
  const SceneFile colored = files.expanded(R"("color_by": "element")");
  const SceneFile by_element = files.expanded(R"("material": "by-element")");
  CHECK(colored.scene == by_element.scene);
  CHECK(colored.legends == by_element.legends);
}

TEST_CASE("coloured particles get the type of a named material") {
  const ColoredScene files;
  const Scene scene = files.expanded(R"("color_by": "type", "material": "gold")").scene;
  const Material& material = scene.materials[scene.spheres[1].material];
  CHECK(material.type == MaterialType::metal);
  CHECK(material.fuzz == 0.25);
  CHECK(material.albedo == category_color(1));
  CHECK(files.refusal(R"("color_by": "type", "material": "glass")") ==
        "6: /particles/0/material: \"color_by\" cannot colour a dielectric (glass): choose a "
        "material of another type");
  CHECK(files.refusal(R"("color_by": "type", "material": "by-element")") ==
        "6: /particles/0/color_by: \"material\" is by-element, which also sets the colour: leave "
        "out one of them");
}

TEST_CASE("errors in a scene's selections and colours name their place") {
  const ColoredScene files;
  const std::vector<std::pair<std::string, std::string>> cases = {
      {"\n\"select\": \"vx > 1 und z\"",
       "7: /particles/0/select: character 8: unexpected 'und': join conditions by 'and' or 'or'"},
      {"\"select\": 3",
       "6: /particles/0/select: expected a string, found a number: write a text in "
       "double quotes"},
      {"\"select\": \" \"",
       "6: /particles/0/select: the selection is empty: write an expression, or \"all\""},
      {"\"select\": \"vx > 7\"",
       "6: /particles/0/select: the selection leaves none of 4 particles: there are vx from -1 to "
       "3"},
      {"\"select\": \"vy > 7\"",
       "6: /particles/0/select: character 1: the file has no numeric column 'vy': did you mean "
       "'y'?"},
      {"\n\n\"hide\": [\"watr\"]",
       "8: /particles/0/hide: 'watr' is not a class of particles: did you mean 'water'?"},
      {"\"hide\": [\"water\"]",
       "6: /particles/0/hide: the file has no residue names: it "
       "has elements, types, x, y, z, fx, fy, fz, index"},
      {"\"hide\": \"water\"",
       "6: /particles/0/hide: this is not a list: write words in brackets, such as "
       "[\"virtual\", \"water\"]"},
      {"\"slice\": \"z\"",
       "6: /particles/0/slice: 'z' is not a slice: write z=10:20, or z=40%:60% "
       "for a part of the cell"},
      {"\"color_by\": \"speed\"",
       "6: /particles/0/color_by: the file has no numeric column 'speed': "
       "known: element, type, chain, residue, atom, x, y, z, fx, fy, fz, index, vx, q"},
      {"\"color_by\": \"chain\"",
       "6: /particles/0/color_by: the file has no chains: it has "
       "elements, types, x, y, z, fx, fy, fz, index"},
      {"\"color_by\": \"vx\", \"colormap\": \"virids\"",
       "6: /particles/0/colormap: unknown colour map 'virids': did you mean 'viridis'?"},
      {"\"colormap\": \"viridis\"",
       "6: /particles/0/colormap: has no effect without \"color_by\": add it"},
      {"\"color_by\": \"type\", \"range\": [0, 1]",
       "6: /particles/0/range: works only with numbers, and 'type' is not a number: leave it out"},
      {"\"color_by\": \"vx\", \"range\": [1, 0]",
       "6: /particles/0/range: low is not below high: write two different numbers, the smaller "
       "first"},
      {"\"color_by\": \"vx\", \"range\": [1]",
       "6: /particles/0/range: the array does not have two numbers: write [low, high]"},
      {"\"color_by\": \"vx\", \"range\": \"a\"",
       "6: /particles/0/range: 'a' is not a range: write two ascending numbers, or two ascending "
       "percentages of the particles, such as 1%:99%"},
  };
  for (const auto& row : cases) {
    const auto& [members, expected] = row;  // which Clang 14 does not capture
    CAPTURE(row.first);
    CHECK(files.refusal(members) == expected);
  }
}

TEST_CASE("selections and colours are written so that they read back equal") {
  const ColoredScene files;
  for (const std::string members :
       {R"("select":"name \"A B\"", "slice":"z=1%:", "hide":[])",
        R"("color_by":"vx", "colormap":"blue-red", "range":[-0.5,1e+30])",
        R"("hide":["water","virtual"])", R"("color_by":"vx", "range":"1%:99.5%")",
        R"("color_by":"vx", "color_scale":"categories")", R"("color_by":"type")"}) {
    CAPTURE(members);
    const SceneFile file = files.read(members);
    std::ostringstream text;
    write_scene(text, file, [] {});
    CHECK(text.str().find(members) != std::string::npos);
    std::istringstream in(text.str());
    const SceneFile again = read_scene(in, "s.json");
    CHECK(again.particles[0].filter == file.particles[0].filter);
    CHECK(again.particles[0].look.coloring == file.particles[0].look.coloring);
  }
}

TEST_CASE("an automatic scene applies its options and keeps them in its reference") {
  const ColoredScene files;
  ParticleSource source;
  source.filter.select = "vx >= 0";
  source.look.coloring.by = "vx";
  const AutoScene portrait = auto_scene(files.path("a.csv"), source, auto_scene_settings());
  CHECK(portrait.file.scene.spheres.size() == 2 + 3);
  CHECK(portrait.file.legends.size() == 1);
  const SceneFile reference = with_reference(portrait, "a.csv");
  CHECK(reference.particles[0].filter == source.filter);
  CHECK(reference.particles[0].look.coloring == source.look.coloring);
  std::ostringstream text;
  write_scene(text, reference, [] {});
  CHECK(text.str().find("\"material\":\"\"") == std::string::npos);
  source.filter.select = "chain A";
  CHECK(message_of<InputError>(
            [&] { (void)auto_scene(files.path("a.csv"), source, auto_scene_settings()); }) ==
        files.path("a.csv") +
            ": --select: character 1: the file has no chains: it has elements, types, x, y, z, "
            "fx, fy, fz, index, vx");
}

TEST_CASE("thousands of numbers become few materials") {
  const ColoredScene files;
  std::string table = "x,y,z,v\n";
  for (int i = 0; i < 5000; ++i) {
    table += std::to_string(i) + ",0,0," + std::to_string(i * 1e-3) + "\n";
  }
  files.write("b.csv", table);
  ParticleSource source;
  source.look.coloring.by = "v";
  const SceneFile file = auto_scene(files.path("b.csv"), source, auto_scene_settings()).file;
  CHECK(file.scene.materials.size() == 2 + color_levels);
}

}  // namespace parray
