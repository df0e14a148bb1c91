#include "cli/measure/tradeoff/bench.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <string>
#include <utility>

#include "cli/measure/tradeoff/variant.h"
#include "common/adaptive/replicates.h"
#include "common/base/error.h"
#include "common/image/image.h"
#include "common/process/stop_signal.h"
#include "common/scene/settings.h"
#include "common/trace/tracer.h"

namespace parray::tradeoff {
namespace {

using nlohmann::json;

/// Number of pairs for each depth and each precision.
constexpr std::uint32_t pairs = 4;
constexpr std::array precisions = {Precision::f32, Precision::mixed};

json to_json(const PairedBias& bias) {
  return {{"mean_square", bias.square},
          {"standard_error", bias.scatter},
          {"mean", bias.mean},
          {"rms", bias.rms()}};
}

PairedBias bias_from(const json& map) {
  return {map.at("mean_square").get<double>(), map.at("standard_error").get<double>(),
          map.at("mean").get<double>()};
}

}  // namespace

const std::shared_ptr<const Accelerator>& Bench::accelerator_for(const RenderSettings& settings) {
  for (const auto& accelerator : accelerators_) {
    if (serves(*accelerator, settings)) return accelerator;
  }
  return accelerators_.emplace_back(
      make_accelerator(scene_, settings.precision, settings.accelerator, settings.isa, threads_));
}

DirectRender Bench::render(const RenderSettings& settings) {
  check_interrupted();
  const auto tracer = make_path_tracer(accelerator_for(settings), scene_.camera, settings);
  auto picture = render_directly(*tracer, scene_, settings, threads_, stop_);
  if (!picture) throw Interrupted();
  return std::move(*picture);
}

DenoisedRender Bench::denoise(const RenderSettings& settings, const DirectRender& picture) {
  const FramebufferView state = picture.state();
  const std::uint32_t samples = *std::ranges::min_element(state.counts);
  if (samples < 2) {
    throw InputError("--denoise needs at least two samples per pixel: use --spp 2 or more");
  }
  const auto tracer = make_path_tracer(accelerator_for(settings), scene_.camera, settings);
  const Effort began = effort_now();
  const Features features = trace_features(*tracer, *steady_tracer(*tracer, scene_, settings),
                                           scene_, settings, samples, threads_, check_interrupted);
  Denoised denoised =
      denoise::denoise(replicates_of(state), features, threads_, settings.isa, check_interrupted);
  return {std::move(denoised), effort_now() - began};
}

void PairedDifference::add(const std::vector<float>& picture, const std::vector<float>& from) {
  sum_.resize(picture.size());
  squares_.resize(picture.size());
  for (std::size_t i = 0; i < picture.size(); ++i) {
    const double difference = static_cast<double>(picture[i]) - static_cast<double>(from[i]);
    sum_[i] += difference;
    squares_[i] += difference * difference;
  }
  ++pairs_;
}

PairedBias PairedDifference::bias() const {
  PairedBias bias;
  double squares = 0;
  const std::size_t pixels = sum_.size() / 3;
  for (std::size_t pixel = 0; pixel < pixels; ++pixel) {
    double product = 0;  // of different pairs; mean over channels, which are not independent
    for (std::size_t i = 3 * pixel; i < 3 * pixel + 3; ++i) {
      product += (sum_[i] * sum_[i] - squares_[i]) / (pairs_ * (pairs_ - 1) * 3);
      bias.mean += sum_[i] / pairs_;
    }
    bias.square += product;
    squares += product * product;
  }
  const auto count = static_cast<double>(pixels);
  bias.mean /= 3 * count;
  bias.square /= count;
  bias.scatter = std::sqrt(std::max(squares / count - bias.square * bias.square, 0.0) / count);
  return bias;
}

std::size_t paired_renders(const RenderSettings& base) {
  return pairs * (depths_of(base.max_depth).size() + 1 + precisions.size() + 1);
}

PairedBiases measure_pairs(Bench& bench, const RenderSettings& base, std::uint32_t samples,
                           const std::function<void(double)>& next) {
  std::map<std::uint32_t, PairedDifference> depth;
  std::map<Precision, PairedDifference> precision;
  std::size_t done = 0;
  const auto picture = [&](const RenderSettings& settings) {
    const DirectRender render = bench.render(settings);
    next(static_cast<double>(++done) / static_cast<double>(paired_renders(base)));
    return resolve_image(render.framebuffer, render.largest_radiance).rgb;
  };
  for (std::uint32_t pair = 0; pair < pairs; ++pair) {
    RenderSettings settings = base;
    settings.samples_per_pixel = samples;
    settings.seed = paired_seed(base.seed, pair);
    RenderSettings turned = settings;
    turned.max_depth = reference_depth(base.max_depth);
    const auto deep = picture(turned);
    for (const std::uint32_t shallow : depths_of(base.max_depth)) {
      turned.max_depth = shallow;
      depth[shallow].add(picture(turned), deep);
    }
    turned = settings;
    turned.precision = Precision::f64;
    const auto exact = picture(turned);
    for (const Precision rough : precisions) {
      turned.precision = rough;
      precision[rough].add(picture(turned), exact);
    }
  }
  PairedBiases biases;
  for (const auto& [key, differences] : depth) biases.depth[key] = differences.bias();
  for (const auto& [key, differences] : precision) biases.precision[key] = differences.bias();
  return biases;
}

json to_json(const PairedBiases& biases) {
  json depth = json::object();
  json precision = json::object();
  for (const auto& [key, bias] : biases.depth) depth[std::to_string(key)] = to_json(bias);
  for (const auto& [key, bias] : biases.precision) {
    precision[std::string(name_of(key))] = to_json(bias);
  }
  return {{"depth", depth}, {"precision", precision}};
}

PairedBiases paired_biases_from(const json& map) {
  PairedBiases biases;
  for (const auto& [key, bias] : map.at("depth").items()) {
    biases.depth[static_cast<std::uint32_t>(std::strtoul(key.c_str(), nullptr, 10))] =
        bias_from(bias);
  }
  for (const auto& [key, bias] : map.at("precision").items()) {
    biases.precision[precision_from(key)] = bias_from(bias);
  }
  return biases;
}

}  // namespace parray::tradeoff
