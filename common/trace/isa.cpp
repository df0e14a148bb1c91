#include "common/trace/isa.h"

namespace parray {

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
#else
    case Isa::avx512:
    case Isa::avx2:
      return false;
#endif
    default:
      return true;
  }
}

Isa best_isa() {
  return runs_on_this_machine(Isa::avx512) ? Isa::avx512
         : runs_on_this_machine(Isa::avx2) ? Isa::avx2
                                           : Isa::scalar;
}

}  // namespace parray
