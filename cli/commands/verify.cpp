#include <algorithm>
#include <array>
#include <bit>
#include <iostream>
#include <iterator>
#include <limits>
#include <map>
#include <memory>
#include <numeric>
#include <optional>
#include <random>
#include <utility>

#include "cli/commands/commands.h"
#include "cli/commands/loading.h"
#include "cli/commands/options.h"
#include "cli/commands/printing.h"
#include "cli/output/denoising.h"
#include "cli/output/recipe.h"
#include "cli/output/text.h"
#include "cli/verify/retrace.h"
#include "common/base/cpu_count.h"
#include "common/base/error.h"
#include "common/base/printable.h"
#include "common/base/sha256.h"
#include "common/image/image_file.h"
#include "common/image/lattice.h"
#include "common/image/srgb.h"
#include "common/image/transparency.h"
#include "common/scene/largest_radiance.h"
#include "common/scene/limits.h"
#include "common/scene/requirements.h"
#include "common/scene/scene_bytes.h"
#include "common/trace/tracer.h"

namespace parray {
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

/// Wrong pixels that the line names, and the document.
constexpr std::size_t most_named = 3;
constexpr std::size_t most_listed = 20;

/// A picture file, read.
struct Subject {
  std::string name;  ///< for people
  ImageFile file;
  Recipe recipe;
  std::string damage{};        ///< of what the picture was made to; empty: none
  std::vector<float> alpha{};  ///< of a transparent picture

  [[nodiscard]] std::uint64_t pixels() const {
    return std::uint64_t{file.image.width} * file.image.height;
  }
  [[nodiscard]] std::array<float, 3> stored(const RetracedPixel& pixel) const {
    const std::size_t at = 3 * (std::size_t{pixel.y} * file.image.width + pixel.x);
    return {file.image.rgb[at], file.image.rgb[at + 1], file.image.rgb[at + 2]};
  }
  [[nodiscard]] bool transparent() const { return !alpha.empty(); }
  /// The name of the hash that its pixels have to have.
  [[nodiscard]] std::string hash() const {
    if (!file.high_dynamic_range) return "pixels_sha256";
    return transparent() ? "transparent:image_sha256" : "image_sha256";
  }
};

struct Verdict {
  std::string damage;  ///< what is wrong with the file by itself; empty: nothing
  std::uint64_t traced = 0;
  std::uint64_t seed = 0;  ///< of the choice of pixels
  std::vector<RetracedPixel> wrong;

  [[nodiscard]] bool right() const { return damage.empty() && wrong.empty(); }
};

// ---- The file by itself ----------------------------------------------------------------------

/// Of a denoised picture, the one that its samples make is looked at.
void take_raw(Subject& subject) {
  if (!subject.file.high_dynamic_range) {
    throw InputError(subject.name +
                     ": denoised, and a PNG has no room for the picture that its samples make: "
                     "verify the EXR picture");
  }
  if (!subject.transparent() &&
      image_sha256(subject.file.image) != subject.recipe.denoised_sha256) {
    subject.damage = "denoised:image_sha256 is not that of its pixels";
  }
  auto raw = raw_image(subject.file);
  if (!raw) {
    throw InputError(subject.name +
                     ": denoised, and its channels raw.R, raw.G, raw.B are gone: "
                     "verify the picture as it was written");
  }
  subject.file.image = *std::move(raw);
  subject.alpha.clear();  // it has its background
}

void take_alpha(Subject& subject) {
  const std::span<const float> alpha = alpha_of(subject.file.channels);
  subject.alpha.assign(alpha.begin(), alpha.end());
  if (!subject.file.high_dynamic_range) {
    if (alpha.empty()) subject.alpha.assign(subject.pixels(), 1);  // that is how a PNG is read
    return;
  }
  if (alpha.empty()) {
    throw InputError(subject.name +
                     ": transparent, and its channel A is gone: verify the picture as it was "
                     "written");
  }
  if (transparent_sha256(subject.file.image, alpha) != subject.recipe.transparent_sha256) {
    subject.damage = subject.hash() + " is not that of its pixels";
  }
}

Subject read_subject(const VerifyCommand& command) {
  Subject subject{printable(command.picture, 4096), read_image(command.picture), {}};
  subject.recipe = recipe_in(subject.file.metadata, subject.name);
  if (!subject.file.high_dynamic_range && subject.recipe.pixels_sha256.empty()) {
    throw InputError(subject.name +
                     ": its recipe has no pixels_sha256: it was converted from an EXR "
                     "picture, which can be verified");
  }
  if (!subject.recipe.finished.empty() && !command.scene.empty()) {
    throw InputError(subject.name + ": " + printable(subject.recipe.finished) +
                     " was drawn on it after it was traced: verify the EXR picture, or leave the "
                     "scene out");
  }
  if (!subject.recipe.transparent_sha256.empty()) take_alpha(subject);
  if (!subject.recipe.denoised_sha256.empty()) take_raw(subject);
  return subject;
}

/// Channel `samples`; null: there is none.
const std::vector<std::uint32_t>* samples_in(const Subject& subject) {
  for (const Channel& channel : subject.file.channels) {
    if (channel.name == samples_channel) {
      return std::get_if<std::vector<std::uint32_t>>(&channel.values);
    }
  }
  return nullptr;
}

/// Why the picture cannot be the recipe's, whatever its pixels are. Empty: it can.
std::string misfit_of(const Subject& subject) {
  const RenderSettings& settings = subject.recipe.settings;
  const Image& image = subject.file.image;
  if (image.width != settings.width || image.height != settings.height) {
    return "it is not " + std::to_string(settings.width) + " x " + std::to_string(settings.height) +
           " pixels, as its recipe says";
  }
  std::uint64_t samples = subject.pixels() * settings.samples_per_pixel;
  if (!subject.recipe.equal_samples) {
    const auto* const counts = samples_in(subject);
    if (counts == nullptr) return "";
    samples = std::accumulate(counts->begin(), counts->end(), std::uint64_t{0});
  }
  if (samples == subject.recipe.samples) return "";
  return "its pixels have " + std::to_string(samples) + " samples, not " +
         std::to_string(subject.recipe.samples) + ", as its recipe says";
}

/// Empty, or what is wrong.
std::string damage_of(const Subject& subject) {
  if (!subject.damage.empty()) return subject.damage;
  const Image& image = subject.file.image;
  if (subject.file.high_dynamic_range) {
    if (subject.transparent()) return "";  // take_alpha() has looked
    if (image_sha256(image) == subject.recipe.image_sha256) return "";
  } else {
    const auto bytes =
        subject.transparent() ? transparent_bytes(image.rgb, subject.alpha) : srgb_bytes(image.rgb);
    if (sha256_hex(std::as_bytes(std::span(bytes))) == subject.recipe.pixels_sha256) return "";
  }
  return subject.hash() + " is not that of its pixels";
}

// ---- Against the scene -----------------------------------------------------------------------

/// Samples of each pixel; empty: all have settings.samples_per_pixel.
std::vector<std::uint32_t> sample_counts(const Subject& subject) {
  if (subject.recipe.equal_samples) return {};
  const auto* const counts = samples_in(subject);
  if (counts == nullptr) {
    throw InputError(subject.name + ": its pixels have different numbers of samples, and " +
                     (subject.file.high_dynamic_range
                          ? "channel samples, which says how many, is gone"
                          : "PNG has no room to say how many") +
                     ": parray render --like " + subject.name + " makes all of it again");
  }
  const std::uint32_t most = *std::max_element(counts->begin(), counts->end());
  if (most > limits::max_samples_per_pixel) {
    throw InputError(subject.name + ": channel samples has " + std::to_string(most) +
                     "; a pixel has at most " + std::to_string(limits::max_samples_per_pixel));
  }
  return *counts;
}

std::vector<RetracedPixel> choose_pixels(const VerifyCommand& command, const Subject& subject,
                                         std::uint64_t seed) {
  const std::vector<std::uint32_t> counts = sample_counts(subject);
  const std::uint32_t width = subject.file.image.width;
  std::vector<RetracedPixel> pixels;
  const std::uint64_t total = subject.pixels();
  for (const std::uint64_t place : choose(command.all ? total : command.pixels, total, seed)) {
    pixels.push_back({static_cast<std::uint32_t>(place % width),
                      static_cast<std::uint32_t>(place / width),
                      counts.empty() ? subject.recipe.settings.samples_per_pixel : counts[place]});
  }
  return pixels;
}

/// The same pixels, or, of those that were filled, what fills them: distinct, sorted.
std::vector<RetracedPixel> sources_of(const std::vector<RetracedPixel>& pixels,
                                      const std::vector<std::uint32_t>& counts,
                                      std::uint32_t width) {
  std::map<std::pair<std::uint32_t, std::uint32_t>, RetracedPixel> sources;
  for (const RetracedPixel& pixel : pixels) {
    const BlockCorner corner = block_corner(counts, width, pixel.x, pixel.y);
    const std::uint32_t samples = counts[std::size_t{corner.y} * width + corner.x];
    sources.try_emplace({corner.y, corner.x}, RetracedPixel{corner.x, corner.y, samples});
  }
  std::vector<RetracedPixel> sorted;
  sorted.reserve(sources.size());
  for (const auto& [place, source] : sources) sorted.push_back(source);
  return sorted;
}

/// Traces the pixels, or what fills them.
void retrace_sources(const PathTracer& tracer, const RadianceScale& scale,
                     const std::vector<std::uint32_t>& counts, std::uint32_t width,
                     std::vector<RetracedPixel>& pixels, int threads, bool transparent) {
  std::vector<RetracedPixel> sources = sources_of(pixels, counts, width);
  retrace(tracer, scale, sources, threads, transparent);
  for (RetracedPixel& pixel : pixels) {
    const BlockCorner corner = block_corner(counts, width, pixel.x, pixel.y);
    const auto source =
        std::ranges::lower_bound(sources, std::pair(corner.y, corner.x), {},
                                 [](const RetracedPixel& one) { return std::pair(one.y, one.x); });
    pixel.mean = source->mean;
    pixel.alpha = source->alpha;
  }
}

bool same_transparent(const Subject& subject, const RetracedPixel& pixel) {
  const std::array<float, 3> stored = subject.stored(pixel);
  const float alpha = subject.alpha[std::size_t{pixel.y} * subject.file.image.width + pixel.x];
  if (subject.file.high_dynamic_range) return stored == pixel.mean && alpha == pixel.alpha;
  return transparent_bytes(stored, {&alpha, 1}) == transparent_bytes(pixel.mean, {&pixel.alpha, 1});
}

bool same(const Subject& subject, const RetracedPixel& pixel) {
  if (subject.transparent()) return same_transparent(subject, pixel);
  const std::array<float, 3> stored = subject.stored(pixel);
  for (std::size_t c = 0; c < 3; ++c) {
    const bool equal =
        subject.file.high_dynamic_range
            ? std::bit_cast<std::uint32_t>(stored[c]) == std::bit_cast<std::uint32_t>(pixel.mean[c])
            : srgb_byte(stored[c]) == srgb_byte(pixel.mean[c]);
    if (!equal) return false;
  }
  return true;
}

void trace_again(const VerifyCommand& command, const Subject& subject, Verdict& verdict) {
  RenderOptions options;
  options.follow(subject.recipe.settings, !subject.recipe.transparent_sha256.empty());
  const SceneFile file = load_scene(command.scene, options);
  check_recipe(subject.recipe, subject.name, scene_identity(file.scene),
               printable(command.scene, 4096));
  verdict.seed = command.seed.value_or(std::random_device()());
  std::vector<RetracedPixel> pixels = choose_pixels(command, subject, verdict.seed);
  const auto threads = static_cast<int>(command.threads.value_or(usable_cpus()));
  const auto settings =
      resolve_settings(requirements_of(file.scene, usable_cpus()), file.settings).settings;
  const auto tracer = make_path_tracer(file.scene, settings, {.threads = threads});
  const RadianceScale scale(largest_radiance(file.scene));
  const auto has_none = [](const RetracedPixel& pixel) { return pixel.samples == 0; };
  if (std::ranges::any_of(pixels, has_none)) {
    retrace_sources(*tracer, scale, sample_counts(subject), subject.file.image.width, pixels,
                    threads, subject.transparent());
  } else {
    retrace(*tracer, scale, pixels, threads, subject.transparent());
  }
  verdict.traced = pixels.size();
  std::copy_if(pixels.begin(), pixels.end(), std::back_inserter(verdict.wrong),
               [&](const RetracedPixel& pixel) { return !same(subject, pixel); });
}

// ---- What is said ----------------------------------------------------------------------------

json document(const VerifyCommand& command, const Subject& subject, const Verdict& verdict) {
  json listed = json::array();
  for (const RetracedPixel& pixel : verdict.wrong) {
    if (listed.size() == most_listed) break;
    listed.push_back({{"x", pixel.x},
                      {"y", pixel.y},
                      {"samples", pixel.samples},
                      {"stored", subject.stored(pixel)},
                      {"traced", pixel.mean}});
  }
  json facts = {{"file", command.picture},
                {"right", verdict.right()},
                {"damage", verdict.damage.empty() ? json() : json(verdict.damage)},
                {"image_sha256", subject.recipe.image_sha256},
                {"scene_sha256", subject.recipe.scene_sha256},
                {"pixels", subject.pixels()},
                {"traced_pixels", verdict.traced},
                {"wrong_pixels", verdict.wrong.size()},
                {"wrong", std::move(listed)}};
  if (verdict.traced > 0) {
    facts["seed"] = verdict.seed;
    facts["share_found"] =
        verdict.traced == subject.pixels() ? 0 : share_found(verdict.traced);  // with 95 %
  }
  return facts;
}

std::string traced_text(const Subject& subject, const Verdict& verdict) {
  if (verdict.traced == 0) return "";
  const bool all = verdict.traced == subject.pixels();
  std::string text = (all ? "all " : "") + counted(verdict.traced, "pixel");
  if (!all) {
    text += " of " + std::to_string(subject.pixels()) + ", picked at random (--seed " +
            std::to_string(verdict.seed) + "),";
  }
  return text + " traced again";
}

std::string right_text(const Subject& subject, const Verdict& verdict) {
  const std::string hash = subject.hash() + " is that of its pixels";
  if (verdict.traced == 0) {
    return hash + "; not checked: whether they are what its scene gives (scene_sha256 " +
           printable(subject.recipe.scene_sha256.substr(0, 16)) + "...): name the scene, too";
  }
  const std::string denoised = subject.recipe.denoised_sha256.empty()
                                   ? ""
                                   : "; looked at: the picture before it was denoised";
  std::string text = "right: " + hash + "; " + traced_text(subject, verdict) + " to the same bits";
  if (verdict.traced < subject.pixels()) {
    text += ", which finds " + formatted("%.2g", 100 * share_found(verdict.traced)) +
            " % of wrong pixels with a probability of 95 %";
  }
  return text + denoised;
}

std::string wrong_text(const Subject& subject, const Verdict& verdict) {
  std::string text = "wrong: " + verdict.damage;
  if (verdict.traced == 0) return text;
  text += (verdict.damage.empty() ? "" : "; ") + traced_text(subject, verdict) + ": " +
          (verdict.wrong.empty() ? "none" : std::to_string(verdict.wrong.size())) + " differ";
  for (std::size_t i = 0; i < std::min(verdict.wrong.size(), most_named); ++i) {
    const RetracedPixel& pixel = verdict.wrong[i];
    text +=
        (i == 0 ? ": (" : ", (") + std::to_string(pixel.x) + ", " + std::to_string(pixel.y) + ")";
  }
  return text + (verdict.wrong.size() > most_named ? ", ..." : "");
}

int verify(const VerifyCommand& command) {
  const Subject subject = read_subject(command);
  Verdict verdict;
  verdict.damage = misfit_of(subject);
  if (verdict.damage.empty()) {
    verdict.damage = damage_of(subject);
    if (!command.scene.empty()) trace_again(command, subject, verdict);
  }
  if (command.as_json) {
    print_json(document(command, subject, verdict));
  } else {
    std::cout << subject.name << ": "
              << (verdict.right() ? right_text(subject, verdict) : wrong_text(subject, verdict))
              << "\n";
  }
  return verdict.right() ? 0 : 1;
}

}  // namespace

void add_verify(CommandLine& line, Action& chosen) {
  Command command = line.command(
      "verify", "Check a finished picture: its hash and, with its scene, pixels traced again");
  const auto options = std::make_shared<VerifyCommand>();
  command.option("PICTURE", options->picture, "EXR or PNG file that ParRay has written")
      .required()
      .completes(Completes::files)
      .forbid_empty();
  command
      .option("SCENE", options->scene,
              "What it was rendered from: a scene file or a file of particles")
      .completes(Completes::files)
      .forbid_empty();
  add_whole_number(
      command, "--pixels", 1, limits::max_pixels,
      [options](std::uint64_t value) { options->pixels = value; },
      "Trace N pixels again, picked at random (default: 299, which find 1 % of wrong pixels with a "
      "probability of 95 %)");
  command.flag("--all", options->all, "Trace every pixel again");
  add_whole_number(
      command, "--seed", 0, std::numeric_limits<std::uint64_t>::max(),
      [options](std::uint64_t value) { options->seed = value; },
      "Pick the same pixels as another time (default: nobody knows which)");
  constexpr std::uint32_t most_threads = 4096;  // the protocol's
  add_whole_number(
      command, "--threads", 1, most_threads,
      [options](std::uint64_t value) { options->threads = static_cast<std::uint32_t>(value); },
      "Threads to trace with (default: every processor that may be used)");
  add_json(command, options->as_json);
  command.example("parray verify glass.exr", "its pixels against the hash in the file");
  command.example("parray verify glass.exr scenes/glass.json", "and 299 of them traced again");
  command.on_chosen([options, &chosen] { chosen = [options] { return verify(*options); }; });
}

}  // namespace parray
