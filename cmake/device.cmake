# Compiles the kernels of a device with clang, without the libraries of a vendor, to <build>/device/: as PTX
# (kernels.ptx, target parray_device_ptx), as SPIR-V (kernels.spv), and as SPIR 1.2 (kernels.spir, target
# parray_device_spirv), which OpenCL drivers without SPIR-V read. The files `fused` are compiled with contraction:
# tests must refuse them. Without clang there are no files, and tests that need them are skipped.
set(PARRAY_DEVICE_DIR ${CMAKE_BINARY_DIR}/device)
set(device_flags -std=c++20 --cuda-device-only -I${CMAKE_SOURCE_DIR})
set(device_flags_ptx -x cuda --cuda-gpu-arch=sm_60 -nocudainc -nocudalib -O3 -S)
# Optimised after the translation: SPIR-V lacks integers that LLVM's passes make.
set(device_flags_spirv -x hip --offload=spirv64 -nogpuinc -nogpulib -O2 -Xclang -disable-llvm-passes -emit-llvm -c)

# Sets `found` to whether clang compiles the standard library's headers for this kind of device.
function(parray_device_check kind found)
  if(NOT DEFINED ${found})
    file(WRITE ${PARRAY_DEVICE_DIR}/check.cu
      "#define __host__ __attribute__((host))\n#define __device__ __attribute__((device))\n#include <cstdlib>\n\n"
      "#include <algorithm>\n#include <vector>\n__attribute__((global)) void kernel(int* a) { *a = 1; }\n")
    execute_process(COMMAND ${PARRAY_CLANG} ${device_flags} ${device_flags_${kind}} -o ${PARRAY_DEVICE_DIR}/check.${kind}
      ${PARRAY_DEVICE_DIR}/check.cu RESULT_VARIABLE failed OUTPUT_QUIET ERROR_QUIET)
    if(failed)
      set(${found} FALSE CACHE INTERNAL "")
    else()
      set(${found} TRUE CACHE INTERNAL "")
    endif()
  endif()
endfunction()

# Compiles the kernels, or those of SOURCE, to `file` in the device folder. The other arguments are flags.
function(parray_device_compile kind file)
  cmake_parse_arguments(PARSE_ARGV 2 device "" "SOURCE" "")
  set(source ${CMAKE_SOURCE_DIR}/common/trace/device/kernels.cu)
  if(device_SOURCE)
    set(source ${device_SOURCE})
  endif()
  set(result ${PARRAY_DEVICE_DIR}/${file})
  add_custom_command(OUTPUT ${result} DEPENDS ${source} DEPFILE ${result}.d VERBATIM
    COMMENT "Compiling device code ${file}"
    COMMAND ${PARRAY_CLANG} ${device_flags} ${device_flags_${kind}} ${device_UNPARSED_ARGUMENTS} -MD -MF ${result}.d -MT ${result} -o ${result}
      ${source})
endfunction()

find_program(PARRAY_CLANG clang++)
if(NOT PARRAY_CLANG)
  message(STATUS "Without device code as PTX and SPIR-V: it needs clang")
  return()
endif()
parray_device_check(ptx PARRAY_DEVICE_PTX)
parray_device_check(spirv PARRAY_DEVICE_SPIRV)
execute_process(COMMAND ${PARRAY_CLANG} -dumpversion OUTPUT_VARIABLE clang_version OUTPUT_STRIP_TRAILING_WHITESPACE)
string(REGEX REPLACE "\\..*" "" clang_version "${clang_version}")
find_program(PARRAY_OPT opt-${clang_version})
find_program(PARRAY_LLVM_AS llvm-as-${clang_version})
find_program(PARRAY_LLVM_DIS llvm-dis-${clang_version})
find_program(PARRAY_LLVM_SPIRV llvm-spirv-${clang_version})

if(PARRAY_DEVICE_PTX)
  # Calls would pass structs through memory.
  parray_device_compile(ptx kernels.ptx -ffp-contract=off -mllvm -inline-threshold=100000)
  parray_device_compile(ptx fused.ptx -ffp-contract=fast -O1)
  add_custom_target(parray_device_ptx DEPENDS ${PARRAY_DEVICE_DIR}/kernels.ptx ${PARRAY_DEVICE_DIR}/fused.ptx)
else()
  message(STATUS "Without device code as PTX: it needs clang with the target nvptx64")
endif()

if(PARRAY_DEVICE_SPIRV AND PARRAY_OPT AND PARRAY_LLVM_DIS AND PARRAY_LLVM_AS AND PARRAY_LLVM_SPIRV)
  set(contract_kernels off)
  set(contract_fused on)
  foreach(name kernels fused)
    set(base ${PARRAY_DEVICE_DIR}/${name})
    parray_device_compile(spirv ${name}.bc -ffp-contract=${contract_${name}})
    # The way back writes a wrong type into attributes `sret`, so that LLVM would optimise results away. What a device
    # may fuse, the files `fused` do fuse.
    add_custom_command(OUTPUT ${base}.spv ${base}.spir DEPENDS ${base}.bc VERBATIM
      COMMAND ${PARRAY_OPT} -passes=always-inline,globaldce ${base}.bc -o ${base}.inlined.bc
      COMMAND ${PARRAY_LLVM_SPIRV} ${base}.inlined.bc -o ${base}.spv
      COMMAND ${PARRAY_LLVM_SPIRV} -r ${base}.spv -o ${base}.back.bc
      COMMAND ${PARRAY_LLVM_DIS} ${base}.back.bc -o ${base}.ll
      COMMAND sed -E -i "s/ sret\\(%\"[^\"]*\" addrspace\\(4\\)\\*\\)//g; s/@_Z3mad(fff|ddd)/@_Z3fma\\1/g" ${base}.ll
      COMMAND ${PARRAY_LLVM_AS} ${base}.ll -o ${base}.spir)
    list(APPEND device_spirv ${base}.spir)
  endforeach()
  add_custom_target(parray_device_spirv DEPENDS ${device_spirv})
else()
  message(STATUS "Without device code as SPIR-V: it needs clang, opt, llvm-as, llvm-dis and llvm-spirv of one version")
endif()
