/// What one scene costs before its first sample, and once: tests/bench/loading runs it in turns.

#include "cli/commands/loading.h"

#include <cstdio>
#include <exception>

#include "common/base/cpu_count.h"
#include "common/scene/requirements.h"
#include "common/scene/scene_bytes.h"
#include "proto/clock.h"
#include "tests/bench/bench.h"
#include "tests/support/rooms.h"

namespace parray::bench {
namespace {

/// Prints how long `work` takes: seconds that pass, and those of the processors.
template <typename Work>
void print_seconds(const Work& work) {
  const SteadyClock clock;
  const Time begin = clock.now();
  const double cpu = cpu_seconds();
  work();
  std::printf("%.4f %.4f ", to_seconds(clock.now() - begin), cpu_seconds() - cpu);
}

}  // namespace
}  // namespace parray::bench

int main(int argc, char** argv) {
  using namespace parray;
  if (argc != 2) {
    std::fputs("usage: bench_loading SCENE\n", stderr);
    return 2;
  }
  try {
    SceneFile file;
    bench::print_seconds([&] { file = load_scene(argv[1], {}); });
    bench::print_seconds([&] { (void)requirements_of(file.scene, usable_cpus()); });
    std::string identity;
    bench::print_seconds([&] { identity = scene_identity(file.scene); });
    std::puts(identity.c_str());
  } catch (const std::exception& error) {
    std::fprintf(stderr, "%s\n", error.what());
    return 1;
  }
}
