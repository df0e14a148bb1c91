#include "common/trace/isa.h"

namespace parray {

bool runs_on_this_machine(Isa isa) {
  switch (isa) {
#if defined(__x86_64__)
    case Isa::avx512:
      return __builtin_cpu_supports("avx512f") != 0 && __builtin_cpu_supports("avx512dq") != 0 &&
             __builtin_cpu_supports("avx512bw") != 0 && __builtin_cpu_supports("avx512vl") != 0 &&
             runs_on_this_machine(Isa::avx2);
    case Isa::avx2:
      return __builtin_cpu_supports("avx2") != 0 && __builtin_cpu_supports("bmi") != 0 &&
             __builtin_cpu_supports("bmi2") != 0 && __builtin_cpu_supports("popcnt") != 0;
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
