/// Compiled once for each instruction set, as isa_kernels.cpp is.
#include "tests/support/lane_operations.h"

#include "tests/support/rooms.h"

#include PARRAY_LANES

namespace parray::test::PARRAY_ISA {

using parray::math::PARRAY_ISA::DoubleLanes;
using parray::math::PARRAY_ISA::FloatLanes;

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
