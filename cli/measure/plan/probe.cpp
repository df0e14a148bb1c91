#include "cli/measure/plan/probe.h"

#include <algorithm>
#include <cmath>
#include <memory>
#include <utility>

#include "cli/farm/direct_render.h"
#include "cli/measure/plan/effort.h"
#include "cli/measure/plan/part_of_picture.h"
#include "common/adaptive/error_estimate.h"
#include "common/adaptive/noise_model.h"
#include "common/adaptive/pixel_noise.h"
#include "common/scene/limits.h"
#include "common/scene/requirements.h"
#include "common/scene/scene_bytes.h"
#include "common/scene/settings.h"
#include "common/trace/selfcheck/fingerprint.h"
#include "common/trace/tracer.h"

namespace parray::plan {
namespace {

// Samples per pixel.
constexpr double look_samples = 4;
constexpr double comparison = 8;  ///< for the sampler of which only the speed is measured
constexpr double adaptive_least = 128;
constexpr double adaptive_most = 4096;
/// Pixels of a part: the usual number if there is time, and the smallest number.
constexpr double usual_pixels = 49152;
constexpr double least_pixels = 8192;
/// The longest time of the probe: a share of the render's time, or these seconds if that is more.
constexpr double share_of_render = 0.5;
constexpr double always_allowed = 1;
/// Share of the time for the survey of the whole picture, and the size of its tiles. Tiles for
/// measuring noise are larger, because pixels need their neighbours.
constexpr double look_share = 0.2;
constexpr PartOfPicture::Tile look_tile{8, 1};
constexpr PartOfPicture::Tile noise_tile{32, 32};

/// Prior knowledge of Owen-scrambled Sobol points, for any scene: errors fall as n^-(1/2 + d).
constexpr ExponentPrior sobol_uniform{0.15, 0.07};
constexpr ExponentPrior sobol_adaptive{0.05, 0.04};

ExponentPrior prior_of(Sampler sampler, ExponentPrior of_sobol) {
  return sampler == Sampler::sobol ? of_sobol : ExponentPrior{0, 0};
}

struct Stopped {};

/// A picture after one of its passes.
struct Stage {
  double samples = 0;  ///< per pixel
  double rmse = 0;
  double relative = 0;  ///< standard error of rmse / rmse
  TracedPass pass;      ///< the latest pass
};

/// Returns the upper end of ErrorEstimate's interval as a function of the error, for a picture of
/// `pixels` pixels.
UpperBound stated_high(const FramebufferView& state, double pixels) {
  const ErrorEstimate error = estimate_rmse(state);
  // factor is approximately e^relative, and relative is proportional to 1/sqrt(pixels).
  const double factor = error.low > 0 ? error.rmse * error.rmse / (error.low * error.low) : 1;
  const double own = static_cast<double>(state.counts.size());
  const double relative = (std::sqrt(2 * factor - 1) - 1) * std::sqrt(own / pixels);
  double seldom = 0;
  for (const std::uint32_t count : state.counts) seldom += 1.0 / count;
  const double unseen =
      3 * state.largest_radiance * state.largest_radiance / pixels * (seldom / own);
  return {1 + relative + relative * relative / 2, unseen};
}

/// Returns the error of `state`. Without noise, returns the smallest error that sums can represent.
Stage stage_of(const FramebufferView& state) {
  const ErrorEstimate error = estimate_rmse(state);
  const double least = RadianceScale(state.largest_radiance).mean(1, 1) / 2;
  if (error.rmse < least) return {0, least, 0, {}};
  return {0, error.rmse, std::log(error.rmse / error.low) / normal_95, {}};
}

/// Returns the variance of a sample of `state`, mean over pixels and channels. `rmse`: the error of
/// `state`.
double variance_of(const FramebufferView& state, double rmse) {
  const RadianceScale scale(state.largest_radiance);
  double sum = 0;
  double biased = 0;
  for (std::size_t i = 0; i < state.pixels.size(); ++i) {
    const PixelNoise noise = noise_of(state.pixels[i], state.counts[i], scale);
    for (const double variance : noise.variance) {
      sum += variance;
      biased += variance * (1 - 1.0 / state.counts[i]);
    }
  }
  // Samples spread less around their own mean than around the true mean, by the error of the mean.
  const double values = 3 * static_cast<double>(state.pixels.size());
  return std::max(biased / values + rmse * rmse, sum / values * 0.5);
}

/// The tracers of a sampler, for the whole picture and for a part of it.
struct Candidate {
  Sampler sampler = Sampler::independent;
  std::unique_ptr<PathTracer> tracer;
  std::unique_ptr<PartOfPicture> part;
};

class Prober {
 public:
  Prober(const ProbeRequest& request, const std::atomic<bool>& stop)
      : request_(request),
        stop_(stop),
        pixels_(static_cast<double>(pixel_count(request.settings))) {}

  Probe run() {
    began_ = effort_now();
    build();
    choose_part();
    const std::vector<Stage> uniform = stages(main_, false, {4, 4, 4, 4, 8, 8, 16});
    error_scale_ = std::sqrt(variance_ / variance_of(render_->state(), uniform.back().rmse));
    cost_scale_ = rays_ / rays_of(*render_);
    result_.stated_uniform = stated_high(render_->state(), pixels_);
    std::vector<Stage> other;
    if (other_) other = stages(*other_, false, {comparison});
    const std::vector<Stage> adaptive = stages(main_, true, adaptive_passes());
    result_.stated_adaptive = stated_high(render_->state(), pixels_);
    add_main(uniform, adaptive);
    if (other_) add_other(other);
    result_.pixels = static_cast<std::uint64_t>(pixels_of_part());
    result_.seconds = (effort_now() - began_).wall;
    return std::move(result_);
  }

 private:
  // ---- Tracing -------------------------------------------------------------------------------

  /// Does and measures the steps that every picture needs once, except loading. Makes the tracers.
  void build() {
    forget_memory();
    trace_fingerprint();
    scene_identity(*request_.scene);
    requirements_of(*request_.scene);
    const RenderSettings& settings = request_.settings;
    accelerator_ = make_accelerator(*request_.scene, settings.precision, settings.accelerator,
                                    settings.isa, request_.threads);
    main_ = candidate(request_.samplers.back());
    result_.fixed = effort_now() - began_;
    if (request_.samplers.size() > 1) other_ = candidate(request_.samplers.front());
    tracing_began_ = effort_now();
  }

  [[nodiscard]] Candidate candidate(Sampler sampler) const {
    PictureSettings picture = request_.settings;
    picture.sampler = sampler;
    return {sampler, make_path_tracer(accelerator_, request_.scene->camera, picture), {}};
  }

  void cut_part(double pixels) {
    const RenderSettings& s = request_.settings;
    const auto most = static_cast<std::uint64_t>(std::min(pixels, pixels_));
    const auto cut = [&](Candidate& one) {
      one.part = std::make_unique<PartOfPicture>(*one.tracer, s.width, s.height, most, noise_tile);
    };
    cut(main_);
    if (other_) cut(*other_);
  }

  /// Chooses the size of the part. A larger part represents the picture better; the pixels of a
  /// smaller part can have more samples in the same time.
  void choose_part() {
    cut_part(least_pixels);
    stages(main_, false, {look_samples});  // touches memory for the first time
    if (other_) stages(*other_, false, {look_samples});
    survey();
    allowed_ = std::min(request_.seconds, std::max(always_allowed, share_of_render * expected()));
    const double each = 48 + (other_ ? comparison : 0) + 1.3 * adaptive_depth();
    cut_part(std::max(least_pixels, seconds_left() / sample_.wall / each));
  }

  /// Returns the approximate time of the render in seconds.
  [[nodiscard]] double expected() const {
    if (request_.error <= 0) return request_.goal_seconds;
    return samples_wanted() * pixels_ * sample_.wall + result_.fixed.wall + result_.overheads.wall;
  }

  /// Traces a few samples everywhere, to scale the results of tiles up to the picture. Also
  /// measures the steps after tracing.
  void survey() {
    // The time of these steps is scaled up from these pixels, so there must be enough of them.
    const double each = sample_.wall * look_samples;
    const double affordable =
        std::clamp(always_allowed / 2 / each, least_pixels,
                   std::max(usual_pixels, look_share * request_.seconds / each));
    const RenderSettings& s = request_.settings;
    const Candidate everywhere{
        main_.sampler,
        {},
        std::make_unique<PartOfPicture>(*main_.tracer, s.width, s.height,
                                        static_cast<std::uint64_t>(std::min(pixels_, affordable)),
                                        look_tile)};
    const Stage look = stages(everywhere, false, {look_samples}).back();
    variance_ = variance_of(render_->state(), look.rmse);
    rays_ = rays_of(*render_);
    const double times = pixels_ / everywhere.part->pixels();
    const Collecting collecting = effort_of_collecting(render_->framebuffer);
    result_.collect = times * collecting.again;
    result_.collect.wall /= request_.threads;  // the other threads trace meanwhile
    const Effort first = measure_overheads(*render_, request_.image.extension());
    const Effort overheads = measure_overheads(*render_, request_.image.extension());
    // The first call also loads libraries, which does not depend on the size of the picture.
    const Effort loading = first - overheads;
    result_.overheads = times * (overheads + collecting.touching) +
                        Effort{std::max(loading.wall, 0.0), std::max(loading.cpu, 0.0)};
    result_.largest_radiance = render_->largest_radiance;
  }

  /// Returns the mean number of segments per path.
  static double rays_of(const DirectRender& render) {
    const TraceCounts& counts = render.framebuffer.counts();
    return static_cast<double>(counts.rays) / static_cast<double>(counts.samples);
  }

  [[nodiscard]] double seconds_left() const {
    return allowed_ - (effort_now() - tracing_began_).wall;
  }

  /// Returns the samples per pixel that the target error needs, within limits.
  [[nodiscard]] double adaptive_depth() const {
    return std::clamp(samples_wanted(), adaptive_least, adaptive_most);
  }
  [[nodiscard]] double samples_wanted() const {
    const double wanted = request_.error > 0 ? variance_ / request_.error / request_.error : 0;
    // Adaptive passes need about 0.6 of it, and with Sobol points half of that.
    return (main_.sampler == Sampler::sobol ? 0.3 : 0.6) * wanted;
  }

  /// Returns the sizes of adaptive passes, in samples per pixel. The second pass adds half as many
  /// as the first, because Sobol points then lose the advantage of a power of two. Later passes
  /// make the total up to four times as large, while there is time and use for them.
  [[nodiscard]] std::vector<double> adaptive_passes() const {
    const double each = 1.3 * sample_.wall * pixels_of_part();
    const double most = std::min(adaptive_depth(), seconds_left() / each);
    double total = 1.5 * pilot_samples;
    std::vector<double> passes = {pilot_samples, total - pilot_samples};
    while (passes.size() < 3 || total < 0.7 * most) {
      const double next = std::clamp(most, 2 * total, 4 * total);
      passes.push_back(next - total);
      total = next;
    }
    return passes;
  }

  [[nodiscard]] double pixels_of_part() const { return main_.part->pixels(); }

  [[nodiscard]] RenderSettings settings_of(const Candidate& one, bool adaptive,
                                           const std::vector<double>& passes) const {
    RenderSettings settings = request_.settings;
    settings.width = one.part->width();
    settings.height = one.part->height();
    settings.sampler = one.sampler;
    settings.adaptive = adaptive;
    settings.samples_per_pixel = limits::max_samples_per_pixel;
    settings.row_order = RowOrder::sequential;
    settings.progressive = false;
    for (const double samples : passes) {
      settings.passes.push_back(static_cast<std::uint64_t>(samples * one.part->pixels()));
    }
    return settings;
  }

  /// Renders the part in `passes` of samples per pixel. Sets render_ to the result.
  std::vector<Stage> stages(const Candidate& one, bool adaptive,
                            const std::vector<double>& passes) {
    const RenderSettings settings = settings_of(one, adaptive, passes);
    std::vector<Stage> found;
    Effort last{};
    double samples_before = 0;
    const auto note = [&](const DirectRender& now) {
      const Effort noting = effort_now();
      const Effort took = Effort{now.seconds, now.cpu_seconds} - last - counting_;
      const auto samples = static_cast<double>(now.framebuffer.counts().samples);
      found.push_back(stage_of(now.state()));
      found.back().samples = now.samples_per_pixel();
      found.back().pass = {samples - samples_before, took};
      if (adaptive && found.size() == 1) measure_deciding(now.state(), settings);
      samples_before = samples;
      last = Effort{now.seconds, now.cpu_seconds} + (effort_now() - noting);
    };
    counting_ = {};
    render_ = render_directly(*one.part, *request_.scene, settings, request_.threads, stop_, note);
    if (!render_) throw Stopped{};
    sample_ = 1 / found.back().pass.samples * found.back().pass.effort;
    result_.samples += render_->framebuffer.counts().samples;
    return found;
  }

  /// Measures the decision between two passes, and makes the model of adaptive passes.
  void measure_deciding(const FramebufferView& state, RenderSettings settings) {
    const Effort began = effort_now();
    const std::uint64_t more = 2 * pilot_samples * state.counts.size();
    const std::vector<std::uint32_t> counts = Placement(state, settings).counts(more);
    counting_ = effort_now() - began;
    // Repeats it with memory that was touched before, as in all passes except the first.
    const Effort again = effort_now();
    Placement placement(state, settings);
    result_.placing_pays = !placement.is_even(more);
    static_cast<void>(placement.counts(more));
    result_.pass = pixels_ / pixels_of_part() * (effort_now() - again);
    if (request_.error > 0) {
      settings.passes.clear();
      settings.target_error = ranges::target_error.least;
      const Effort looking = effort_now();
      next_pass_size(state, settings, 1, placement);
      // Not scaled up: a decision on a large picture reads no more pixels than this part has.
      result_.pass = result_.pass + (effort_now() - looking);
    }
    adaptive_model_ = ModelError::adaptive(state, stage_of(state).rmse);
  }

  // ---- Results -------------------------------------------------------------------------------

  /// Returns the error law of passes with the same number of samples in every pixel.
  [[nodiscard]] ErrorModel even_law(const std::vector<Stage>& stages) const {
    return {ModelError::uniform(std::sqrt(variance_)), measured(stages),
            prior_of(main_.sampler, sobol_uniform),
            main_.sampler == Sampler::sobol ? Spread::points : Spread::smooth};
  }

  void add_main(const std::vector<Stage>& uniform, const std::vector<Stage>& adaptive) {
    SamplerProbe found{main_.sampler,
                       even_law(uniform),
                       result_.placing_pays ? ErrorModel(*adaptive_model_, measured(adaptive),
                                                         prior_of(main_.sampler, sobol_adaptive))
                                            : even_law(adaptive),
                       {},
                       {}};
    std::vector<TracedPass> equal = passes_of(uniform);
    equal.push_back(adaptive.front().pass);
    times_ = fit_pass_cost(equal);
    found.uniform_sample = cost_scale_ * times_.sample;
    found.adaptive_sample = found.uniform_sample;
    if (result_.placing_pays) {
      const std::vector<Stage> later(adaptive.begin() + 1, adaptive.end());
      found.adaptive_sample = cost_scale_ * sample_effort(passes_of(later), times_.pass);
    }
    // A part of a pass's time is fixed, and a part grows with the pixels. Passes of one size cannot
    // separate the parts, so this takes the mean of both extremes.
    const double times = (1 + pixels_ / pixels_of_part()) / 2;
    result_.collect = result_.collect + times * times_.pass;
    result_.timing_doubt = times_.doubt;
    result_.samplers.push_back(std::move(found));
  }

  /// Adds the other sampler. Only its speed was measured, because the variance of a sample does not
  /// depend on the sampler.
  void add_other(const std::vector<Stage>& stages) {
    const SamplerProbe main = result_.samplers.front();
    const double share = sample_effort(passes_of(stages), times_.pass).cpu / times_.sample.cpu;
    const double pilot_rmse = std::sqrt(variance_ / pilot_samples);
    const ExponentPrior none = prior_of(other_->sampler, sobol_uniform);
    SamplerProbe found{
        other_->sampler,
        ErrorModel(ModelError::uniform(std::sqrt(variance_)),
                   std::vector<MeasuredError>{{1, std::sqrt(variance_), 0.01}}, none),
        ErrorModel(*adaptive_model_, std::vector<MeasuredError>{{pilot_samples, pilot_rmse, 0.01}},
                   none),
        share * main.uniform_sample, share * main.adaptive_sample};
    result_.samplers.insert(result_.samplers.begin(), std::move(found));
  }

  [[nodiscard]] std::vector<MeasuredError> measured(const std::vector<Stage>& stages) const {
    std::vector<MeasuredError> errors;
    errors.reserve(stages.size());
    for (const Stage& stage : stages) {
      errors.push_back({stage.samples, error_scale_ * stage.rmse, stage.relative});
    }
    return errors;
  }

  static std::vector<TracedPass> passes_of(const std::vector<Stage>& stages) {
    std::vector<TracedPass> passes;
    passes.reserve(stages.size());
    for (const Stage& stage : stages) passes.push_back(stage.pass);
    return passes;
  }

  const ProbeRequest& request_;
  const std::atomic<bool>& stop_;
  const double pixels_;  ///< pixels of the picture
  Effort began_;
  Effort tracing_began_;
  std::shared_ptr<const Accelerator> accelerator_;
  Candidate main_;
  std::optional<Candidate> other_;
  std::optional<DirectRender> render_;
  std::optional<ModelError> adaptive_model_;
  double allowed_ = 0;      ///< seconds for tracing
  double variance_ = 0;     ///< variance of a sample, mean over the picture
  double rays_ = 0;         ///< segments of a sample, mean over the picture
  double error_scale_ = 1;  ///< the picture's error divided by the part's
  double cost_scale_ = 1;   ///< the picture's cost of a sample divided by the part's
  PassCost times_;          ///< of the main sampler, on the part
  Effort sample_;           ///< the latest pass's effort per sample, including its fixed part
  Effort counting_;         ///< effort of counting the samples of the next pass
  Probe result_;
};

}  // namespace

std::optional<Probe> probe(const ProbeRequest& request, const std::atomic<bool>& stop) {
  try {
    return Prober(request, stop).run();
  } catch (const Stopped&) {
    return std::nullopt;
  }
}

}  // namespace parray::plan
