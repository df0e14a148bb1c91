// Prints the descriptions of settings and of a scene's sections as JSON: what scenes/schema/renew
// makes the schema and the keywords of Python from, and compares them with.
#include <algorithm>
#include <iostream>
#include <nlohmann/json.hpp>
#include <string>
#include <type_traits>

#include "cli/input/scene_file/particle_fields.h"
#include "cli/input/scene_file/scene_fields.h"
#include "cli/scene_sandbox/upload_jobs.h"
#include "common/scene/settings.h"
#include "tests/support/rooms.h"

namespace parray::input {
namespace {

using Json = nlohmann::ordered_json;

Json number(NumberRange range) {
  return {{"type", "number"}, {"minimum", range.least}, {"maximum", range.most}};
}

// The leaf of a JSON schema by the rule of a setting.
Json leaf(IntegerRange range) {
  return {{"type", "integer"}, {"minimum", range.least}, {"maximum", range.most}};
}
Json leaf(NumberRange range) { return number(range); }
Json leaf(Flag /*rule*/) { return {{"type", "boolean"}}; }
Json leaf(OnOff /*rule*/) { return {{"type", "boolean"}}; }
Json leaf(Passes /*rule*/) { return {{"type", "array"}, {"items", {{"type", "integer"}}}}; }
Json leaf(const Words& words) { return {{"enum", words.names}}; }
Json leaf(LabelText rule) {
  return {{"type", "string"}, {"minLength", 1}, {"maxLength", rule.longest}};
}
Json leaf(Vec3Range range) {
  return {{"type", "array"}, {"minItems", 3}, {"maxItems", 3}, {"items", number(range)}};
}
Json leaf(LineWidthRange range) {
  return {{"anyOf", Json::array({{{"type", "boolean"}}, number(range)})}};
}
Json leaf(ShareRange range) { return leaf(LineWidthRange{range}); }
Json leaf(FileName /*rule*/) { return {{"type", "string"}, {"minLength", 1}}; }
// The schema alone describes the texts of these members.
template <typename T>
Json leaf(const TextRule<T>& /*rule*/) {
  return Json::object();
}
Json leaf(Representations /*rule*/) { return {{"type", "array"}}; }
Json leaf(HiddenClasses /*rule*/) { return {{"type", "array"}}; }

template <typename Describe>
Json leaves(const Describe& describe, unsigned section = 0) {
  Json required = Json::array();
  Json properties = Json::object();
  describe([&](const Setting& setting, const auto& rule, const auto& value) {
    if (section != 0 && !setting.is(section)) return;
    Json one = leaf(rule);
    using T = std::decay_t<decltype(value)>;
    if constexpr (std::is_integral_v<T>) one["default"] = value;
    if (setting.help != nullptr) one["description"] = setting.help;
    properties[setting.key] = one;
    if (setting.is(traits::required)) required.push_back(setting.key);
  });
  return {{"required", required}, {"properties", properties}};
}

// The type of Python by the rule.
std::string python_type(IntegerRange /*range*/) { return "int"; }
std::string python_type(NumberRange /*range*/) { return "float"; }
std::string python_type(OnOff /*rule*/) { return "bool"; }
std::string python_type(Passes /*rule*/) { return "Sequence[int]"; }
std::string python_type(const Words& words) {
  std::string names;
  for (const std::string_view name : words.names) {
    names += (names.empty() ? "\"" : ", \"") + std::string(name) + "\"";
  }
  return "Literal[" + names + "]";
}

/// The options of an upload by HTTP that are no settings. A text may also be given as a number or
/// a list.
Json upload_options() {
  CommandLine line("", "parray");
  Command command = line.command("submit", "");
  scene_sandbox::UploadRequest request;
  scene_sandbox::add_upload_options(command, request);
  Json options = Json::object();
  const ProgramText program = line.description();
  for (const OptionText& option : program.commands.front().options) {
    std::string name = option.names.back().substr(2);
    if (name == "help" || name == "transparent") continue;  // of the program; not for farms
    std::ranges::replace(name, '-', '_');
    const bool on_off = option.value.empty() || option.value == "on|off";
    const bool number = option.value == "N" || option.value == "DEG" || option.value == "FACTOR";
    const bool switched = option.value.starts_with("on|off|");
    Json one = {{"type", on_off           ? Json("boolean")
                         : number         ? Json("number")
                         : switched       ? Json::array({"boolean", "number", "string"})
                         : name == "show" ? Json::array({"string", "object", "array"})
                                          : Json::array({"string", "number", "array"})},
                {"description", option.text}};
    if (!on_off && !option.words.empty()) one["examples"] = option.words;
    options[name] = one;
  }
  return options;
}

Json document() {
  const RenderSettings settings;
  const bool transparent = false;
  const auto all = [&](const auto& f) { image_fields(f, settings, transparent); };
  Json sections = {{"image", leaves(all, traits::image)}, {"render", leaves(all, traits::render)}};
  sections["camera"] = leaves([o = Camera{}](const auto& f) { camera_fields(f, o); });
  sections["sky"] = leaves([o = Sky{}](const auto& f) { sky_fields(f, o); });
  sections["finishing"] =
      leaves([o = Postprocessing{}](const auto& f) { postprocessing_fields(f, o); });
  sections["labels"] = leaves([o = LabelSettings{}](const auto& f) { label_fields(f, o); });
  sections["particles"] = leaves([o = ParticleSource{}](const auto& f) { particle_fields(f, o); });
  Json materials = Json::array();
  for (std::size_t i = 0; i < scene_words::materials.size(); ++i) {
    const Material material{.type = static_cast<MaterialType>(i)};
    materials.push_back(
        leaves([&](const auto& f) { material_fields(f, material.type, material); }));
  }
  Json keywords = Json::object();
  settings_fields([&](const Setting& setting, const auto& rule) {
    if (setting.help == nullptr) return;
    keywords[keyword_of(setting)] = {{"python", python_type(rule)}, {"schema", leaf(rule)}};
  });
  return {{"sections", sections},
          {"materials", materials},
          {"keywords", keywords},
          {"upload_options", upload_options()}};
}

}  // namespace
}  // namespace parray::input

int main() {
  std::cout << parray::input::document().dump(1) << "\n";
  return 0;
}
