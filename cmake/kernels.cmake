# Compiles one source once for each instruction set. Programs choose the set at run time. Kernels are optimised in every
# build type, because forced inlining of this much code at -O0 takes gigabytes. (GCC 12 warns about uninitialised
# variables in its own intrinsics, so these warnings are off.)
set(isa_flags_scalar -O3)  # runs on every processor; -O3 unrolls the loops over lanes
if(CMAKE_SYSTEM_PROCESSOR MATCHES "x86_64|AMD64")
  # Exactly the features that isa.cpp looks for in the processor.
  set(isa_flags_avx2 -mavx2 -mfma -mbmi -mbmi2 -mpopcnt)
  set(isa_flags_avx512 ${isa_flags_avx2} -mavx512f -mavx512dq -mavx512vl -mavx512bw)
elseif(CMAKE_SYSTEM_PROCESSOR MATCHES "aarch64|arm64")
  set(isa_flags_neon -O3)  # as scalar
endif()
# Adds the objects of `source`, compiled with `option` for each instruction set, to the list `objects`.
function(parray_kernels objects name source option)
  foreach(isa scalar avx2 avx512 neon)
    if(DEFINED isa_flags_${isa})
      set(kernel parray_${name}_${isa})
      add_library(${kernel} OBJECT ${source})
      target_link_libraries(${kernel} PRIVATE parray_flags)
      target_compile_definitions(${kernel} PRIVATE PARRAY_ISA=${isa} PARRAY_LANES="common/math/lanes_${isa}.h")
      target_compile_options(${kernel} PRIVATE ${option} ${isa_flags_${isa}}
        "$<$<CXX_COMPILER_ID:GNU>:-Wno-maybe-uninitialized;-Wno-uninitialized>")
      list(APPEND ${objects} $<TARGET_OBJECTS:${kernel}>)
    endif()
  endforeach()
  set(${objects} ${${objects}} PARENT_SCOPE)
endfunction()
