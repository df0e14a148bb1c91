#include "common/trace/isa.h"

namespace parray::trace {

bool runs_on_this_machine(Isa isa) {
  switch (isa) {
#if defined(__x86_64__)
    case Isa::avx512:
      return __builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512dq") &&
             __builtin_cpu_supports("avx512bw") && __builtin_cpu_supports("avx512vl") &&
             runs_on_this_machine(Isa::avx2);
    case Isa::avx2:
      return __builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma") &&
             __builtin_cpu_supports("bmi") && __builtin_cpu_supports("bmi2") &&
             __builtin_cpu_supports("popcnt");
#elif defined(__aarch64__)
    case Isa::neon:  // every aarch64 processor has it
      return true;
#endif
    default: return isa == Isa::automatic || isa == Isa::scalar;
  }
}

std::vector<Isa> instruction_sets() {
  std::vector<Isa> sets;
  for (const Isa isa : {Isa::scalar, Isa::avx2, Isa::avx512, Isa::neon}) {
    if (runs_on_this_machine(isa)) sets.push_back(isa);
  }
  return sets;
}

Isa best_isa() { return instruction_sets().back(); }

}  // namespace parray::trace
