// ParRay against the same integrator on Embree's sphere points, on one core: samples and rays a
// second, bytes a sphere, seconds to build. All trace the same samples in the same turns, so that
// the ratios are of like with like. Seconds are processor time.
#include <CLI/CLI.hpp>
#include <array>
#include <cmath>
#include <cstdio>
#include <fstream>
#include <iostream>
#include <nlohmann/json.hpp>

#include "common/base/error.h"
#include "common/math/float_mode.h"
#include "common/scene/largest_radiance.h"
#include "common/scene/requirements.h"
#include "common/scene/settings.h"
#include "common/trace/tracer.h"
#include "tests/bench/bench.h"
#include "tests/bench/bench_scenes.h"
#include "tests/bench/embree_peer.h"
#include "tests/support/rooms.h"

#if !defined(PARRAY_BENCH_ISA)
#define PARRAY_BENCH_ISA "auto"
#endif

namespace {

using namespace parray;
using namespace parray::bench;
using Json = nlohmann::ordered_json;

constexpr std::uint32_t samples_a_call = 16;
constexpr std::uint32_t samples_a_pixel = 64;
/// Standard errors by which mean pictures may differ. Chance would allow 3; but the random numbers
/// are the same, and so are nearly all paths.
constexpr double tolerated_errors = 1;
constexpr std::array<EmbreePeer::Variant, 2> variants{EmbreePeer::Variant::single,
                                                      EmbreePeer::Variant::packet};
constexpr std::array<const char*, variants.size()> variant_names{"single", "packet"};

/// Calls of one turn: rows spread over the picture, samples_a_call samples of each pixel.
struct Turn {
  std::size_t first_step;
  std::size_t steps;

  template <typename Trace>
  void each_call(const RenderSettings& settings, const Trace& trace) const {
    for (std::size_t step = first_step; step < first_step + steps; ++step) {
      const auto chunk =
          static_cast<std::uint32_t>(step / settings.height % (samples_a_pixel / samples_a_call));
      trace(PixelRun{row_at(step, settings), 0, settings.width},
            SampleRange{chunk * samples_a_call, (chunk + 1) * samples_a_call});
    }
  }
};

/// What a contestant has done so far.
template <typename Sums>
struct Record {
  explicit Record(const RenderSettings& settings)
      : sums(std::size_t{settings.width} * settings.height), samples_of_row(settings.height) {}

  std::vector<Sums> sums;                     ///< of each pixel
  std::vector<std::uint32_t> samples_of_row;  ///< of each of its pixels
  TraceCounts counts;
  std::vector<double> rates;  ///< samples a second, in each round
};

template <typename Sums, typename Trace>
void take_turn(const Turn& turn, const RenderSettings& settings, Record<Sums>& record,
               const Trace& trace) {
  const std::uint64_t samples_before = record.counts.samples;
  const double begin = cpu_seconds();
  turn.each_call(settings, [&](const PixelRun& run, const SampleRange& samples) {
    const std::size_t row = std::size_t{run.y} * settings.width;
    trace(run, samples, std::span(record.sums).subspan(row, settings.width), record.counts);
    record.samples_of_row[run.y] += samples.count();
  });
  record.rates.push_back(static_cast<double>(record.counts.samples - samples_before) /
                         (cpu_seconds() - begin));
}

struct Moments {
  double mean;
  double mean_square;
};

/// Mean of the picture in each channel, and that mean's variance, from the spread in each pixel.
struct Mean {
  std::array<double, 3> value{};
  std::array<double, 3> variance{};
};

template <typename Sums, typename MomentsOf>
Mean mean_of(const Record<Sums>& record, const RenderSettings& settings,
             const MomentsOf& moments_of) {
  Mean mean;
  const auto total = static_cast<double>(record.counts.samples);
  for (std::size_t i = 0; i < record.sums.size(); ++i) {
    const double n = record.samples_of_row[i / settings.width];
    for (std::size_t c = 0; c < 3 && n > 1; ++c) {
      const Moments pixel = moments_of(record.sums[i], c, n);
      mean.value[c] += pixel.mean * n / total;
      const double spread =
          std::max(pixel.mean_square - pixel.mean * pixel.mean, 0.0) * n / (n - 1);
      mean.variance[c] += spread * n / (total * total);
    }
  }
  return mean;
}

/// The largest difference of two mean pictures over the channels, in standard errors of one.
double difference_in_errors(const Mean& a, const Mean& b) {
  double worst = 0;
  for (std::size_t c = 0; c < 3; ++c) {
    worst = std::max(worst, std::abs(a.value[c] - b.value[c]) / std::sqrt(a.variance[c]));
  }
  return worst;
}

/// One scene, both contestants.
class Match {
 public:
  Match(const Scene& scene, const RenderSettings& settings);

  void play();

  /// The row of the table, and the object of the JSON file.
  [[nodiscard]] Json result() const;

 private:
  using PeerRecord = Record<PeerSums>;

  void build();
  [[nodiscard]] std::size_t steps_a_turn() const;
  void take_turn_of_ours(const Turn& turn, Record<PixelSums>& record) const;
  void take_turn_of_peer(const Turn& turn, std::size_t variant);
  [[nodiscard]] Mean our_mean() const;
  [[nodiscard]] Json speed_of_peer(std::size_t variant, const Mean& ours) const;

  const Scene& scene_;
  RenderSettings settings_;
  std::unique_ptr<PathTracer> tracer_;
  std::unique_ptr<EmbreePeer> peer_;
  std::vector<double> our_builds_;  // seconds
  std::vector<double> peer_builds_;
  Record<PixelSums> ours_;
  std::array<PeerRecord, variants.size()> peers_;
};

Match::Match(const Scene& scene, const RenderSettings& settings)
    : scene_(scene),
      settings_(settings),
      ours_(settings),
      peers_{PeerRecord(settings), PeerRecord(settings)} {
  build();
}

/// In turns, as often as it is quick.
void Match::build() {
  // More than once, because memory that a virtual machine has never touched costs it twice.
  const std::size_t times = scene_.spheres.size() < 5'000'000 ? 5 : 3;
  for (std::size_t i = 0; i < times; ++i) {
    peer_.reset();
    peer_ = std::make_unique<EmbreePeer>(scene_, settings_);
    peer_builds_.push_back(peer_->build_seconds());
    tracer_.reset();
    const double begin = cpu_seconds();
    tracer_ = make_path_tracer(scene_, settings_);
    our_builds_.push_back(cpu_seconds() - begin);
  }
}

/// As many calls as take ParRay's kernel a turn's time, measured on rows all over the picture.
std::size_t Match::steps_a_turn() const {
  constexpr std::size_t tried = 10;
  Record<PixelSums> trial(settings_);
  take_turn_of_ours({0, tried}, trial);  // warms up
  take_turn_of_ours({0, tried}, trial);
  return static_cast<std::size_t>(seconds_a_turn * trial.rates.back() /
                                  (settings_.width * samples_a_call)) +
         1;
}

void Match::play() {
  const std::size_t steps = steps_a_turn();
  for (std::size_t round = 0; round < rounds; ++round) {
    const Turn turn{round * steps, steps};
    take_turn_of_ours(turn, ours_);
    for (std::size_t variant = 0; variant < variants.size(); ++variant) {
      take_turn_of_peer(turn, variant);
    }
  }
}

void Match::take_turn_of_ours(const Turn& turn, Record<PixelSums>& record) const {
  const FloatMode ieee;
  take_turn(turn, settings_, record,
            [this](const PixelRun& run, const SampleRange& samples, std::span<PixelSums> sums,
                   TraceCounts& counts) { tracer_->trace(run, samples, sums, counts); });
}

void Match::take_turn_of_peer(const Turn& turn, std::size_t variant) {
  take_turn(
      turn, settings_, peers_[variant],
      [&](const PixelRun& run, const SampleRange& samples, std::span<PeerSums> sums,
          TraceCounts& counts) { peer_->trace(variants[variant], run, samples, sums, counts); });
}

Mean Match::our_mean() const {
  const RadianceScale scale(largest_radiance(scene_));
  return mean_of(ours_, settings_, [&](const PixelSums& pixel, std::size_t channel, double n) {
    const auto count = static_cast<std::uint64_t>(n);
    return Moments{scale.mean(pixel.sum[channel], count),
                   scale.mean_square(pixel.sum_of_squares[channel], count)};
  });
}

double rays_a_sample(const TraceCounts& counts) {
  return static_cast<double>(counts.rays) / static_cast<double>(counts.samples);
}

Json Match::speed_of_peer(std::size_t variant, const Mean& ours) const {
  const Record<PeerSums>& record = peers_[variant];
  const Mean mean =
      mean_of(record, settings_, [](const PeerSums& pixel, std::size_t channel, double n) {
        return Moments{pixel.sum[channel] / n, pixel.sum_of_squares[channel] / n};
      });
  const double rate = median(record.rates);
  return {{"samples_per_second", rate},
          {"rays_per_second", rate * rays_a_sample(record.counts)},
          {"rays_to_parray", rays_a_sample(record.counts) / rays_a_sample(ours_.counts)},
          {"standard_errors_from_parray", difference_in_errors(ours, mean)}};
}

Json Match::result() const {
  const std::size_t shapes = scene_.spheres.size() + scene_.capsules.size();
  const auto count = static_cast<double>(shapes);
  const double rate = median(ours_.rates);
  const std::size_t fastest = median(peers_[1].rates) > median(peers_[0].rates) ? 1 : 0;
  std::vector<double> ratios;
  for (std::size_t round = 0; round < rounds; ++round) {
    ratios.push_back(ours_.rates[round] / peers_[fastest].rates[round]);
  }
  const auto [low, high] = std::minmax_element(ratios.begin(), ratios.end());
  const auto our_bytes = static_cast<double>(tracer_->accelerator()->bytes());
  const auto peer_bytes = static_cast<double>(peer_->bytes());
  const Mean mean = our_mean();
  Json result;
  result["spheres"] = shapes;
  result["scene"] = scene_.spheres.empty()    ? "sticks"
                    : shapes < smallest_cloud ? "one-weekend"
                                              : "cloud";
  result["parray"] = {{"samples_per_second", rate},
                      {"rays_per_second", rate * rays_a_sample(ours_.counts)},
                      {"isa", tracer_->isa()},
                      {"accelerator", name_of(settings_.accelerator)},
                      {"bytes_per_sphere", our_bytes / count},
                      {"build_seconds", median(our_builds_)}};
  result["embree"] = {{"single", speed_of_peer(0, mean)},
                      {"packet", speed_of_peer(1, mean)},
                      {"fastest", variant_names[fastest]},
                      {"bytes_per_sphere", peer_bytes / count},
                      {"peak_bytes_per_sphere", static_cast<double>(peer_->peak_bytes()) / count},
                      {"build_seconds", median(peer_builds_)}};
  result["ratio"] = {{"speed", rate / median(peers_[fastest].rates)},
                     {"lowest_round", *low},
                     {"highest_round", *high},
                     {"bytes", our_bytes / peer_bytes},
                     {"build", median(our_builds_) / median(peer_builds_)}};
  return result;
}

void print_head() {
  std::printf(
      "%s, one core; compiler %s; Embree %s, ParRay %s\n"
      "300 x 200 pixels, depth 10, %u samples per pixel in calls of a row x %u; medians of %zu "
      "rounds\n"
      "of turns of about %.1f s. Ratio: ParRay to the faster of two Embree variants, single rays\n"
      "(rtcIntersect1) and packets (rtcIntersect16; 8 under AVX2), and its range. Apart: how far "
      "the\n"
      "mean pictures lie from ParRay's, in standard errors. Bytes: ParRay's accelerator; all that\n"
      "Embree holds, with its vertex buffer. Build: make_accelerator() with all its copying; "
      "rtcCommitScene\n"
      "alone.\n\n",
      processor().c_str(), __VERSION__, embree_version(), PARRAY_VERSION, samples_a_pixel,
      samples_a_call, rounds, seconds_a_turn);
  std::puts(
      "          Msamples/s (Mrays/s)                                                  "
      "bytes a sphere          build, s");
  std::puts(
      " spheres  ParRay          single          packet           ratio                apart  "
      "ours  Embree ratio   ours     Embree   ratio");
}

void print_row(const Json& r) {
  const auto speed = [](const Json& of) {
    std::printf("%6.3f (%6.2f)  ", of["samples_per_second"].get<double>() / 1e6,
                of["rays_per_second"].get<double>() / 1e6);
  };
  std::printf("%8zu  ", r["spheres"].get<std::size_t>());
  const Json& embree = r["embree"];
  speed(r["parray"]);
  speed(embree["single"]);
  speed(embree["packet"]);
  const auto number = [](const Json& of, const char* key) { return of[key].get<double>(); };
  const Json& ratio = r["ratio"];
  std::printf("%5.2f (%4.2f .. %4.2f)  ", number(ratio, "speed"), number(ratio, "lowest_round"),
              number(ratio, "highest_round"));
  std::printf("%5.2f  ", std::max(number(embree["single"], "standard_errors_from_parray"),
                                  number(embree["packet"], "standard_errors_from_parray")));
  std::printf("%5.1f  %5.1f %5.2f  ", number(r["parray"], "bytes_per_sphere"),
              number(embree, "bytes_per_sphere"), number(ratio, "bytes"));
  std::printf("%8.2g %8.2g  %5.2f\n", number(r["parray"], "build_seconds"),
              number(embree, "build_seconds"), number(ratio, "build"));
  static_cast<void>(std::fflush(stdout));
}

/// False, and a line on standard error, where a peer's mean picture is not ParRay's.
bool pictures_agree(const Json& r) {
  bool agree = true;
  for (const char* name : variant_names) {
    const auto errors = r["embree"][name]["standard_errors_from_parray"].get<double>();
    if (!(errors <= tolerated_errors)) {
      agree = false;
      std::cerr << r["spheres"] << " spheres: the mean picture of Embree's " << name << " lies "
                << errors << " standard errors from ParRay's\n";
    }
  }
  return agree;
}

Json play_match(std::uint32_t spheres, bool sticks, const std::string& folder) {
  const Scene scene = sticks ? bench::sticks(spheres) : scene_of_size(spheres, folder);
  RenderSettings asked = small_picture();
  asked.precision = Precision::f32;
  asked.isa = isa_from(PARRAY_BENCH_ISA);
  Match match(scene, resolve_settings(requirements_of(scene), asked).settings);
  match.play();
  return match.result();
}

int run(const std::vector<std::uint32_t>& sizes, bool sticks, const std::string& folder,
        const std::string& json_file) {
  warn_of_assertions();
  pin_to_one_core();
  print_head();
  Json report{{"processor", processor()},
              {"compiler", __VERSION__},
              {"embree_version", embree_version()},
              {"version", PARRAY_VERSION},
              {"width", 300},
              {"height", 200},
              {"max_depth", 10},
              {"samples_per_pixel", samples_a_pixel},
              {"rounds", rounds},
              {"seconds_a_turn", seconds_a_turn},
              {"matches", Json::array()}};
  bool agree = true;
  for (const std::uint32_t spheres : sizes) {
    report["matches"].push_back(play_match(spheres, sticks, folder));
    print_row(report["matches"].back());
    agree = pictures_agree(report["matches"].back()) && agree;
  }
  if (!json_file.empty()) {
    std::ofstream out(json_file);
    out << report.dump(2) << '\n';
    if (!out.flush()) throw std::runtime_error(json_file + ": cannot be written");
  }
  return agree ? 0 : 1;
}

int benchmark(int argc, char** argv) {
  CLI::App app("ParRay against the same integrator on Embree's sphere points, on one core");
  std::vector<std::uint32_t> sizes{8, 20, 486, 4097, 100'000, 1'000'000, 10'000'000};
  bool sticks = false;
  std::string folder = ".";
  std::string json_file;
  app.add_option("--spheres", sizes, "sizes of the scenes; from 100000 on, clouds")
      ->delimiter(',')
      ->check(CLI::Range(4U, 100'000'000U));
  app.add_flag("--sticks", sticks, "clouds of capsules, against Embree's round curves");
  app.add_option("--scenes", folder, "folder of one-weekend-N.json, for the smaller sizes");
  app.add_option("--json", json_file, "file to write the results to");
  try {
    app.parse(argc, argv);
    return run(sizes, sticks, folder, json_file);
  } catch (const CLI::ParseError& error) {
    return app.exit(error) == 0 ? 0 : 2;
  } catch (const InputError& error) {
    std::cerr << error.what() << '\n';
    return 2;
  } catch (const std::exception& error) {
    std::cerr << error.what() << '\n';
    return 1;
  }
}

}  // namespace

int main(int argc, char** argv) {
  try {
    return benchmark(argc, argv);
  } catch (...) {  // not even the message could be made
    return 1;
  }
}
