#include <algorithm>
#include <filesystem>
#include <iostream>
#include <limits>
#include <memory>
#include <optional>
#include <random>

#include "cli/check/verify/against_scene.h"
#include "cli/commands/commands.h"
#include "cli/commands/loading.h"
#include "cli/commands/options.h"
#include "cli/commands/printing.h"
#include "cli/output/extra_channels.h"
#include "cli/output/picture/transparency.h"
#include "cli/output/text.h"
#include "common/base/cpu_count.h"
#include "common/base/error.h"
#include "common/base/printable.h"
#include "common/base/text.h"
#include "common/scene/limits.h"
#include "common/scene/requirements.h"
#include "common/scene/scene_bytes.h"

namespace parray::commands {
namespace {

using nlohmann::json;

struct VerifyCommand {
  std::string picture;
  std::string scene;           ///< empty: nothing is traced
  std::uint64_t pixels = 299;  ///< 1 - 0.99^299 = 0.95
  bool all = false;
  std::optional<std::uint64_t> seed;
  std::optional<std::uint32_t> threads;
  bool as_json = false;
};

/// How many wrong pixels the text and the JSON list.
constexpr std::size_t most_named = 3;
constexpr std::size_t most_listed = 20;

struct Verdict {
  std::string damage;      ///< a fault of the file itself; empty: none
  std::uint64_t seed = 0;  ///< seed of the choice of pixels
  VerificationResults findings{};

  [[nodiscard]] bool right() const { return damage.empty() && findings.right(); }
};

void trace_again(const VerifyCommand& command, const VerifiedPicture& picture, Verdict& verdict) {
  RenderOptions options;
  options.follow(picture.recipe.settings, !picture.recipe.transparent_sha256.empty());
  const SceneFile file = load_scene(command.scene, options);
  check_recipe(picture.recipe, picture.name, scene_identity(file.scene),
               printable(command.scene, 4096));
  verdict.seed = command.seed.value_or(std::random_device()());
  const auto threads = static_cast<int>(command.threads.value_or(usable_cpus()));
  const auto settings =
      resolve_settings(requirements_of(file.scene, usable_cpus()), file.settings).settings;
  verdict.findings = check_against_scene(picture, file.scene, settings,
                                         {command.pixels, command.all, verdict.seed}, threads);
}

// ---- Output ----------------------------------------------------------------------------------

/// Returns the channels of the file that were not checked. Channels of one kind have one name, such
/// as "half_width.*".
std::vector<std::string> unchecked_channels(const VerifiedPicture& picture,
                                            const Verdict& verdict) {
  std::vector<std::string> names;
  for (const Channel& channel : picture.file.channels) {
    const bool known = channel.name == samples_channel || channel.name == alpha_channel ||
                       channel.name.starts_with(raw_channel) ||
                       verdict.findings.channels.contains(channel.name);
    const std::string name = channel.name.substr(0, channel.name.find('.'));
    const bool part = name.size() < channel.name.size();
    const std::string shown = printable(part ? name + ".*" : name, 100);
    if (!known && std::ranges::find(names, shown) == names.end()) names.push_back(shown);
  }
  return names;
}

/// Returns the facts that were not checked, although a reader could think so.
std::vector<std::string> not_checked(const VerifiedPicture& picture, const Verdict& verdict) {
  std::vector<std::string> list;
  const VerificationResults& findings = verdict.findings;
  if (findings.traced == 0) list.emplace_back("whether the pixels are what the scene gives");
  if (!findings.error) list.emplace_back("the stated error");
  if (!picture.recipe.denoised_sha256.empty()) list.emplace_back("the denoised picture's error");
  if (!picture.recipe.equal_samples) list.emplace_back("how many samples each pixel was given");
  for (const std::string& name : unchecked_channels(picture, verdict)) {
    list.push_back("channel " + name);
  }
  return list;
}

json error_json(const VerificationResults& findings) {
  if (!findings.error) return nullptr;
  const ErrorCheck& error = *findings.error;
  return {{"stated", error.stated},
          {"traced", error.traced},
          {"uncertainty", error.uncertainty},
          {"right", !error.wrong}};
}

json document(const VerifyCommand& command, const VerifiedPicture& picture,
              const Verdict& verdict) {
  const VerificationResults& findings = verdict.findings;
  json listed = json::array();
  for (const RetracedPixel& pixel : findings.wrong) {
    if (listed.size() == most_listed) break;
    listed.push_back({{"x", pixel.x},
                      {"y", pixel.y},
                      {"samples", pixel.samples},
                      {"stored", picture.stored(pixel)},
                      {"traced", pixel.mean}});
  }
  json facts = {{"file", command.picture},
                {"right", verdict.right()},
                {"damage", verdict.damage.empty() ? json() : json(verdict.damage)},
                {"image_sha256", picture.recipe.image_sha256},
                {"scene_sha256", picture.recipe.scene_sha256},
                {"pixels", picture.pixels()},
                {"traced_pixels", findings.traced},
                {"wrong_pixels", findings.wrong.size()},
                {"wrong", std::move(listed)},
                {"wrong_in_channels", findings.channels},
                {"error", error_json(findings)},
                {"not_checked", not_checked(picture, verdict)}};
  if (findings.traced > 0) {
    facts["seed"] = verdict.seed;
    facts["share_found"] =
        findings.traced == picture.pixels() ? 0 : share_found(findings.traced);  // with 95 %
  }
  return facts;
}

std::string traced_text(const VerifiedPicture& picture, const Verdict& verdict) {
  const std::uint64_t traced = verdict.findings.traced;
  const bool all = traced == picture.pixels();
  std::string text = (all ? "all " : "") + counted(traced, "pixel");
  if (!all) {
    text += " of " + std::to_string(picture.pixels()) + ", picked at random (--seed " +
            std::to_string(verdict.seed) + "),";
  }
  return text + " traced again";
}

/// `all`: all pixels were traced.
std::string error_check_text(const ErrorCheck& error, bool all) {
  const auto number = [](double value) { return formatted("%.3g", value); };
  const std::string traced =
      all ? number(error.traced) : number(error.traced) + " +- " + number(error.uncertainty);
  if (error.wrong) {
    return "the stated error " + number(error.stated) +
           (all ? " or its interval does not match the pixels, whose error is "
                : " is too low: the error of these pixels is ") +
           traced;
  }
  return all ? "the stated error is that of the pixels"
             : "stated error " + number(error.stated) + ", error of these pixels " + traced;
}

std::string right_text(const VerifiedPicture& picture, const Verdict& verdict) {
  const VerificationResults& findings = verdict.findings;
  const std::string hash = picture.hash() + " matches the pixels";
  const std::string left = "; not checked: " + joined(not_checked(picture, verdict), ", ");
  if (findings.traced == 0) {
    return hash + left + " (scene_sha256 " + printable(picture.recipe.scene_sha256.substr(0, 16)) +
           "...): add the scene to the command to check more";
  }
  std::string text = "right: " + hash + "; " + traced_text(picture, verdict) + " with the same " +
                     (picture.file.high_dynamic_range ? "bits" : "8-bit values");
  const bool all = findings.traced == picture.pixels();
  if (!all) {
    text += "; if " + formatted("%.2g", 100 * share_found(findings.traced)) +
            " % of all pixels were wrong, this would find one with a probability of 95 %";
  }
  std::vector<std::string> channels;
  for (const auto& [name, wrong] : findings.channels) channels.push_back(name);
  if (!channels.empty()) text += "; these channels are right, too: " + joined(channels, ", ");
  if (findings.error) text += "; " + error_check_text(*findings.error, all);
  if (!picture.recipe.denoised_sha256.empty()) text += "; checked: the picture before denoising";
  return not_checked(picture, verdict).empty() ? text : text + left;
}

std::string wrong_text(const VerifiedPicture& picture, const Verdict& verdict) {
  const VerificationResults& findings = verdict.findings;
  std::vector<std::string> parts;
  if (!verdict.damage.empty()) parts.push_back(verdict.damage);
  if (findings.traced > 0) {
    const std::vector<RetracedPixel>& wrong = findings.wrong;
    std::string text = traced_text(picture, verdict) + ": " +
                       (wrong.empty() ? "none" : std::to_string(wrong.size())) + " differ";
    for (std::size_t i = 0; i < std::min(wrong.size(), most_named); ++i) {
      text += (i == 0 ? ": (" : ", (") + std::to_string(wrong[i].x) + ", " +
              std::to_string(wrong[i].y) + ")";
    }
    parts.push_back(text + (wrong.size() > most_named ? ", ..." : ""));
  }
  for (const auto& [name, wrong] : findings.channels) {
    if (wrong > 0) parts.push_back("channel " + name + " differs in " + counted(wrong, "pixel"));
  }
  if (findings.error && findings.error->wrong) {
    parts.push_back(error_check_text(*findings.error, findings.traced == picture.pixels()));
  }
  return "wrong: " + joined(parts, "; ");
}

bool has_picture_name(const std::string& file) {
  const auto extension = std::filesystem::path(file).extension();
  return extension == ".exr" || extension == ".png" || extension == ".tif" || extension == ".tiff";
}

int verify(const VerifyCommand& command) {
  if (has_picture_name(command.scene) && !has_picture_name(command.picture)) {
    const std::string right_order = command.scene + " " + command.picture;
    throw InputError("give the picture before its scene: parray verify " +
                     printable(right_order, 4096));
  }
  const VerifiedPicture picture = read_verified_picture(command.picture, !command.scene.empty());
  Verdict verdict{misfit_of(picture)};
  if (verdict.damage.empty()) {
    verdict.damage = damage_of(picture);
    if (!command.scene.empty()) trace_again(command, picture, verdict);
  }
  if (command.as_json) {
    print_json(document(command, picture, verdict));
  } else {
    std::cout << picture.name << ": "
              << (verdict.right() ? right_text(picture, verdict) : wrong_text(picture, verdict))
              << "\n";
  }
  return verdict.right() ? 0 : 1;
}

}  // namespace

void add_verify(CommandLine& line) {
  Command command = line.command(
      "verify",
      "Check a finished picture: its hash and, with its scene, some pixels, traced again");
  const auto options = std::make_shared<VerifyCommand>();
  add_file(command, "PICTURE", options->picture, "EXR, PNG or TIFF file that ParRay has written")
      .required();
  const Option scene = add_file(command, "SCENE", options->scene,
                                "Scene of the picture: a scene file or a file of particles");
  Option pixels = add_whole_number(
      command, "--pixels", 1, limits::max_pixels, options->pixels,
      "Trace N pixels again, chosen at random (default: 299. If 1 % of all pixels are wrong, they "
      "find one with a probability of 95 %)");
  pixels.needs(scene);
  Option all = command.flag("--all", options->all, "Trace every pixel again");
  all.needs(scene).excludes(pixels);
  add_whole_number(command, "--seed", 0, std::numeric_limits<std::uint64_t>::max(), options->seed,
                   "Seed of the choice of pixels (default: random)")
      .needs(scene)
      .excludes(all);
  add_threads(command, options->threads).needs(scene);
  add_json(command, options->as_json);
  command.example("parray verify glass.exr", "compares the pixels with the hash in the file");
  command.example("parray verify glass.exr scenes/glass.json", "also traces 299 pixels again");
  command.runs([options] { return verify(*options); });
}

}  // namespace parray::commands
