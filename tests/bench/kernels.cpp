// The tracing kernels of this build, a turn whenever asked, so that two builds can take turns: see
// tests/bench/kernels. Arguments: precision, instruction set, folder of one-weekend-N.json, sizes.
// A line "SIZE FIRST STEPS" on standard input traces that many rows of the scene; the answer is
// the seconds of processor that it took and a hash of the sums. "SIZE build" makes its accelerator
// anew: seconds, bytes.
#include <cstdio>
#include <exception>
#include <iostream>
#include <map>
#include <string>

#include "common/base/sha256.h"
#include "common/math/float_mode.h"
#include "common/scene/requirements.h"
#include "common/scene/settings.h"
#include "common/trace/tracer.h"
#include "tests/bench/bench.h"
#include "tests/bench/bench_scenes.h"
#include "tests/support/rooms.h"

namespace {

using namespace parray;
using namespace parray::bench;

struct Contestant {
  Scene scene;
  RenderSettings settings;
  std::unique_ptr<PathTracer> tracer;

  void build() {
    tracer.reset();
    tracer = make_path_tracer(scene, settings);
  }
};

Contestant contestant(std::uint32_t size, const std::string& folder, RenderSettings asked) {
  Contestant made{scene_of_size(size, folder), asked, nullptr};
  made.settings = resolve_settings(requirements_of(made.scene), asked).settings;
  made.build();
  return made;
}

void trace_rows(const Contestant& who, std::size_t first, std::size_t steps) {
  constexpr SampleRange samples{0, 16};
  const FloatMode ieee;
  std::vector<PixelSums> sums(who.settings.width);
  TraceCounts counts;
  const double begin = cpu_seconds();
  for (std::size_t step = first; step < first + steps; ++step) {
    who.tracer->trace({row_at(step, who.settings), 0, who.settings.width}, samples, sums, counts);
  }
  const double seconds = cpu_seconds() - begin;
  std::printf("%.9g %s %llu %llu\n", seconds,
              sha256_hex(std::as_bytes(std::span(sums))).substr(0, 16).c_str(),
              static_cast<unsigned long long>(counts.samples),
              static_cast<unsigned long long>(counts.rays));
}

void answer(std::map<std::uint32_t, Contestant>& contestants) {
  std::uint32_t size = 0;
  for (std::string what; std::cin >> size >> what;) {
    Contestant& who = contestants.at(size);
    if (what == "build") {
      const double begin = cpu_seconds();
      who.build();
      std::printf("%.9g %zu\n", cpu_seconds() - begin, who.tracer->accelerator()->bytes());
    } else {
      std::size_t steps = 0;
      std::cin >> steps;
      trace_rows(who, std::stoul(what), steps);
    }
    static_cast<void>(std::fflush(stdout));
  }
}

int run(const std::vector<std::string>& arguments) {
  pin_to_one_core();
  RenderSettings asked = small_picture();
  asked.precision = precision_from(arguments.at(0));
  asked.isa = isa_from(arguments.at(1));
  std::map<std::uint32_t, Contestant> contestants;
  for (std::size_t i = 3; i < arguments.size(); ++i) {
    const auto size = static_cast<std::uint32_t>(std::stoul(arguments[i]));
    contestants.emplace(size, contestant(size, arguments[2], asked));
  }
  answer(contestants);
  return 0;
}

}  // namespace

int main(int argc, char** argv) {
  try {
    return run({argv + 1, argv + argc});
  } catch (const std::exception& error) {
    std::cerr << error.what() << '\n';
    return 2;
  }
}
