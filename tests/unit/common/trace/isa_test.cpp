#include "common/trace/isa.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <fstream>
#include <set>
#include <sstream>
#include <string>
#include <vector>

#include "common/scene/settings.h"
#include "tests/support/rooms.h"
#include "tests/support/sample_scenes.h"

namespace parray::test {
namespace {

/// What Linux says that programs may use of this processor; empty where it does not say.
std::set<std::string> processor_flags() {
  std::ifstream info("/proc/cpuinfo");
  for (std::string line; std::getline(info, line);) {
    if (line.starts_with("flags")) {
      std::istringstream words(line.substr(line.find(':') + 1));
      std::set<std::string> flags;
      for (std::string word; words >> word;) flags.insert(word);
      return flags;
    }
  }
  return {};
}

bool has_all(const std::set<std::string>& flags, const std::set<std::string>& needed) {
  return std::includes(flags.begin(), flags.end(), needed.begin(), needed.end());
}

}  // namespace

TEST_CASE("an instruction set runs only where the processor has all that its kernels use") {
  CHECK(runs_on_this_machine(Isa::scalar));
  const std::set<std::string> flags = processor_flags();
  // What common/CMakeLists.txt lets the compiler use, as the operating system names it.
  const std::set<std::string> v3{"avx2", "bmi1", "bmi2", "popcnt"};
  const std::set<std::string> v4{"avx512f", "avx512bw", "avx512dq", "avx512vl"};
  if (runs_on_this_machine(Isa::avx2)) CHECK(has_all(flags, v3));
  if (runs_on_this_machine(Isa::avx512)) {
    CHECK(has_all(flags, v4));
    CHECK(runs_on_this_machine(Isa::avx2));
  }
#if defined(__x86_64__)
  CHECK(runs_on_this_machine(Isa::avx2) == has_all(flags, v3));
  CHECK(runs_on_this_machine(Isa::avx512) == (has_all(flags, v3) && has_all(flags, v4)));
#endif
#if defined(__aarch64__)
  CHECK(instruction_sets() == std::vector{Isa::scalar, Isa::neon});
#else
  CHECK(!runs_on_this_machine(Isa::neon));
#endif
}

TEST_CASE("the best instruction set is the widest that runs") {
  const Isa best = best_isa();
  CHECK(runs_on_this_machine(best));
  for (const Isa isa : {Isa::scalar, Isa::avx2, Isa::avx512, Isa::neon}) {
    CHECK((isa <= best || !runs_on_this_machine(isa)));
  }
}

TEST_CASE("a kernel takes the instruction set that is asked for, or the best there is") {
  const Scene scene = small_scene();
  RenderSettings settings = small_settings(scene);
  for (const Isa isa : {Isa::automatic, Isa::scalar, Isa::avx2, Isa::avx512, Isa::neon}) {
    settings.isa = isa;
    const bool asked = isa != Isa::automatic && runs_on_this_machine(isa);
    CHECK(make_path_tracer(scene, settings)->isa() == name_of(asked ? isa : best_isa()));
  }
}

}  // namespace parray::test
