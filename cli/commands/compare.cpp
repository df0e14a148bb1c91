#include <algorithm>
#include <iostream>
#include <memory>
#include <optional>

#include "cli/check/compare/flip.h"
#include "cli/check/compare/metrics.h"
#include "cli/commands/commands.h"
#include "cli/commands/options.h"
#include "cli/commands/printing.h"
#include "cli/output/input_files.h"
#include "cli/output/picture/image_file.h"
#include "cli/output/picture/transparency.h"
#include "cli/output/text.h"
#include "common/base/error.h"
#include "common/base/printable.h"
#include "common/process/stop_signal.h"

namespace parray::commands {
namespace {

using nlohmann::json;

struct CompareCommand {
  std::string reference;
  std::vector<std::string> images;
  std::string verification;  ///< the verification picture; empty: none
  bool as_json = false;
};

struct Comparison {
  std::string file;
  std::string image_sha256;  ///< from its metadata; empty: none
  bool identical = false;
  ErrorMetrics errors;
  double flip = 0;
  std::optional<HdrFlip> hdr_flip;  ///< nothing: one of the two pictures has 8 bits
};

/// Returns the definition of each number in the JSON. F: a picture, R: the reference.
json formulas() {
  const std::string epsilon = number_text(relative_epsilon);
  return {
      {"mse", "mean of (F - R)^2 over the values (channels of pixels) of linear RGB"},
      {"rmse", "sqrt(mse)"},
      {"psnr", "-10 log10(mse), in dB, for a peak of 1; null if mse is 0"},
      {"relmse", "mean of (F - R)^2 / (R^2 + " + epsilon + ")"},
      {"smape", "mean of |F - R| / (|F| + |R| + " + epsilon + ")"},
      {"mae", "mean of |F - R|"},
      {"bias", "mean of F - R"},
      {"p999", "the least number that |F - R| of 99.9 % of the values does not exceed"},
      {"max", "largest |F - R|, in pixel (x, y) from the top left"},
      {"flip", "mean FLIP (Andersson et al. 2020), 67 pixels a degree, values clamped to [0, 1]"},
      {"hdr_flip",
       "mean HDR-FLIP (Andersson et al. 2021), ACES, exposures from the reference; null unless "
       "both pictures are EXR"}};
}

std::string sha256_in(const ImageFile& file) {
  return text_in(file.metadata, "parray:image_sha256").value_or("");
}

std::string size_text(const Image& image) {
  return std::to_string(image.width) + " x " + std::to_string(image.height);
}

void check_same_size(const CompareCommand& command, const Image& reference, const std::string& file,
                     const Image& image) {
  if (image.width != reference.width || image.height != reference.height) {
    throw InputError(printable(file, 4096) + " has " + size_text(image) + " pixels and " +
                     printable(command.reference, 4096) + " has " + size_text(reference) +
                     ": compare pictures of the same size");
  }
}

/// Throws InputError if one picture is transparent and the other is not. Their colours are not
/// comparable: a transparent picture has premultiplied ones.
void check_same_background(const CompareCommand& command, const ImageFile& reference,
                           const std::string& file, const ImageFile& image) {
  const bool transparent = !alpha_of(image.channels).empty();
  if (transparent == !alpha_of(reference.channels).empty()) return;
  throw InputError(printable(transparent ? file : command.reference, 4096) +
                   " is transparent and " +
                   printable(transparent ? command.reference : file, 4096) +
                   " is not: render both with --transparent on, or both without it");
}

void check_verification_path(const CompareCommand& command) {
  if (command.verification.empty()) return;
  check_image_path(command.verification);
  InputFiles inputs{command.reference};
  for (const std::string& image : command.images) inputs.add(image);
  inputs.check(command.verification);
}

Comparison comparison_of(const std::string& name, const ImageFile& reference,
                         const ImageFile& file) {
  Comparison result;
  result.file = name;
  result.image_sha256 = sha256_in(file);
  result.identical = same_bits(reference.image, file.image) &&
                     std::ranges::equal(alpha_of(reference.channels), alpha_of(file.channels));
  result.errors = error_metrics(reference.image, file.image);
  result.flip = mean_of(flip(reference.image, file.image));
  if (reference.high_dynamic_range && file.high_dynamic_range) {
    result.hdr_flip = hdr_flip(reference.image, file.image);
  }
  return result;
}

// ---- JSON ------------------------------------------------------------------------------------

json text_or_null(const std::string& text) { return text.empty() ? json() : json(text); }

/// Returns the JSON of a comparison. Numbers that are not finite become null when it is printed.
json json_of(const Comparison& one) {
  const ErrorMetrics& errors = one.errors;
  json object = {{"file", one.file},
                 {"image_sha256", text_or_null(one.image_sha256)},
                 {"identical", one.identical},
                 {"mse", errors.mse},
                 {"rmse", errors.rmse},
                 {"psnr", errors.psnr},
                 {"relmse", errors.relative_mse},
                 {"smape", errors.smape},
                 {"mae", errors.mean_absolute},
                 {"bias", errors.bias},
                 {"p999", errors.absolute_999},
                 {"max", errors.largest_absolute},
                 {"x", errors.any() ? json(errors.worst_x) : json()},
                 {"y", errors.any() ? json(errors.worst_y) : json()},
                 {"flip", one.flip},
                 {"hdr_flip", nullptr},
                 {"hdr_flip_exposures", nullptr},
                 {"nonfinite_pixels", errors.nonfinite_in_image},
                 {"excluded_pixels", errors.excluded}};
  if (one.hdr_flip) {
    object["hdr_flip"] = mean_of(one.hdr_flip->map);
    object["hdr_flip_exposures"] = {{"start", one.hdr_flip->start_exposure},
                                    {"stop", one.hdr_flip->stop_exposure},
                                    {"count", one.hdr_flip->exposures}};
  }
  return object;
}

json document(const CompareCommand& command, const ImageFile& reference,
              const std::vector<Comparison>& comparisons, float largest) {
  json images = json::array();
  for (const Comparison& one : comparisons) images.push_back(json_of(one));
  return {{"version", PARRAY_VERSION},
          {"reference",
           {{"file", command.reference},
            {"image_sha256", text_or_null(sha256_in(reference))},
            {"width", reference.image.width},
            {"height", reference.image.height},
            {"nonfinite_pixels", comparisons.front().errors.nonfinite_in_reference}}},
          {"images", images},
          {"verification_picture",
           {{"file", text_or_null(command.verification)}, {"largest", largest}}},
          {"formulas", formulas()}};
}

// ---- Text ------------------------------------------------------------------------------------

std::string cell(double value) { return formatted("%.3g", value); }

/// Shortens a name that is too long for the table. Keeps its end, which differs more often.
std::string name_cell(const std::string& file) {
  constexpr std::size_t widest = 28;
  if (file.size() <= widest) return printable(file, 4 * widest);
  return "..." + printable(file.substr(file.size() - (widest - 3)), 4 * widest);
}

std::string at_cell(const ErrorMetrics& errors) {
  if (!errors.any()) return "-";
  return std::to_string(errors.worst_x) + "," + std::to_string(errors.worst_y);
}

void print_tables(const std::vector<Comparison>& comparisons) {
  std::vector<std::vector<std::string>> means;
  std::vector<std::vector<std::string>> extremes;
  for (const Comparison& one : comparisons) {
    const ErrorMetrics& e = one.errors;
    const std::string name = name_cell(one.file);
    means.push_back({name, cell(e.mse), cell(e.rmse), formatted("%.2f", e.psnr),
                     cell(e.relative_mse), cell(e.smape), cell(e.mean_absolute), cell(e.bias)});
    extremes.push_back({name, cell(e.absolute_999), cell(e.largest_absolute), at_cell(e),
                        formatted("%.4f", one.flip),
                        one.hdr_flip ? formatted("%.4f", mean_of(one.hdr_flip->map)) : "n/a",
                        one.identical ? "yes" : "no"});
  }
  std::cout << table_text({"image", "MSE", "RMSE", "PSNR", "relMSE", "SMAPE", "MAE", "bias"}, means)
            << "\n"
            << table_text({"image", "p99.9", "max", "at x,y", "FLIP", "HDR-FLIP", "identical"},
                          extremes);
}

void print_legend() {
  const std::string epsilon = number_text(relative_epsilon);
  std::cout
      << "\nR: reference, F: image; all values are channels of linear RGB.\n"
         "MSE: mean of (F - R)^2. PSNR: in dB, for a peak of 1.\n"
         "relMSE: mean of (F - R)^2 / (R^2 + "
      << epsilon << "). SMAPE: mean of |F - R| / (|F| + |R| + " << epsilon
      << ").\n"
         "MAE: mean of |F - R|. p99.9: 99.9 % of all |F - R| are at most this. bias: mean of F - "
         "R.\n"
         "FLIP: visible difference, from 0 (same) to 1; values are clamped to [0, 1], as on a "
         "screen.\n"
         "HDR-FLIP: the same at all exposures, not clamped, for two EXR files only.\n";
}

void print_comparison_notes(const CompareCommand& command, const ImageFile& reference,
                            const std::vector<Comparison>& comparisons) {
  for (const Comparison& one : comparisons) {
    const std::string name = printable(one.file, 500);
    if (!one.identical && !one.image_sha256.empty() && one.image_sha256 == sha256_in(reference)) {
      std::cout << name << ": has the image_sha256 of " << printable(command.reference, 500)
                << ", so both files come from the same traced picture\n";
    }
  }
}

void print_text(const CompareCommand& command, const ImageFile& reference,
                const std::vector<Comparison>& comparisons, float largest) {
  std::cout << "reference " << printable(command.reference, 500) << ": "
            << size_text(reference.image) << " pixels\n\n";
  print_tables(comparisons);
  print_legend();
  print_comparison_notes(command, reference, comparisons);
  if (!command.verification.empty()) {
    std::cout << "wrote " << printable(command.verification, 500)
              << ": white minus V, the sum of |F - R| over " << counted(comparisons.size(), "image")
              << "; largest V " << cell(static_cast<double>(largest)) << "\n";
  }
}

/// Prints a line on stderr for each picture with pixels that were left out. Returns whether there
/// is one.
bool warn_of_excluded(const std::vector<Comparison>& comparisons) {
  bool any = false;
  for (const Comparison& one : comparisons) {
    if (one.errors.excluded == 0) continue;
    any = true;
    std::cerr << "parray: warning: " << printable(one.file, 4096) << ": "
              << counted(one.errors.excluded, "pixel")
              << " left out, because not finite: " << one.errors.nonfinite_in_image
              << " in this picture, " << one.errors.nonfinite_in_reference << " in the reference, "
              << one.errors.nonfinite_in_both() << " in both\n";
  }
  return any;
}

// ---- The command -----------------------------------------------------------------------------

int compare(const CompareCommand& command) {
  check_verification_path(command);
  const ImageFile reference = read_image(command.reference);
  check_image_size(command.verification, reference.image.width, reference.image.height);
  DifferenceImage verification(reference.image);
  std::vector<Comparison> comparisons;
  for (const std::string& name : command.images) {
    const ImageFile file = read_image(name);
    check_same_size(command, reference.image, name, file.image);
    check_same_background(command, reference, name, file);
    comparisons.push_back(comparison_of(name, reference, file));
    verification.add(file.image);
  }
  if (!command.verification.empty()) {
    const DeferredInterrupts deferred;
    write_image(command.verification, verification.drawn(), {}, {}, check_interrupted);
  }
  const bool excluded = warn_of_excluded(comparisons);
  const float largest = verification.largest();
  command.as_json ? print_json(document(command, reference, comparisons, largest))
                  : print_text(command, reference, comparisons, largest);
  return excluded ? 1 : 0;
}

}  // namespace

void add_compare(CommandLine& line) {
  Command command = line.command("compare", "Measure how much pictures differ from a reference");
  const auto options = std::make_shared<CompareCommand>();
  add_file(command, "REF", options->reference, "Reference: a picture in any known format")
      .required();
  command.option("IMAGE", options->images, "Pictures to compare with REF; they must have its size")
      .required()
      .forbid_empty()
      .completes(Completes::files);
  add_file(command, "-o,--output", options->verification,
           "Write the verification picture: white minus the sum of "
           "|REF - IMAGE| over all pictures, not scaled (.exr or .png)")
      .type_name("V.png")
      .group(output_group);
  add_json(command, options->as_json);
  command.example("parray compare reference.exr a.exr b.png -o difference.png",
                  "prints a row for each picture, and draws where they differ");
  command.runs([options] { return compare(*options); });
}

}  // namespace parray::commands
