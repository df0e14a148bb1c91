/// Compiled once for each instruction set, as isa_kernels.cpp is.
#include "tests/support/lane_operations.h"

#if defined(__AVX512F__)
#include "common/math/lanes_avx512.h"
#elif defined(__AVX2__)
#include "common/math/lanes_avx2.h"
#endif

namespace parray::test::PARRAY_ISA {
namespace {

#if defined(__AVX512F__)
using FloatLanes = parray::avx512::Float16;
using DoubleLanes = parray::avx512::Double8;
#elif defined(__AVX2__)
using FloatLanes = parray::avx2::Float8;
using DoubleLanes = parray::avx2::Double4;
#else
using FloatLanes = Lanes<float, parray::scalar::float_width>;
using DoubleLanes = Lanes<double, parray::scalar::double_width>;
#endif

}  // namespace

void operate(const LaneInputs<float>& in, LaneResults<float>& out) {
  operate_on_reals<FloatLanes>(in, out);
  operate_on_masks<FloatLanes>(in, out);
  operate_on_uints<FloatLanes>(in, out);
}

void operate(const LaneInputs<double>& in, LaneResults<double>& out) {
  operate_on_reals<DoubleLanes>(in, out);
  operate_on_masks<DoubleLanes>(in, out);
  operate_on_uints<DoubleLanes>(in, out);
}

}  // namespace parray::test::PARRAY_ISA
