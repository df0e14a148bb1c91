# A room is a library of its own, so that a program links what its rooms may use and no more:
# parray_room(NAME [SOURCES FILE...] [LINKS TARGET...] [PRIVATE TARGET...]) makes parray_NAME, alias
# parray::NAME. LINKS are the rooms and libraries that its headers may include, PRIVATE those that
# only its sources may. The table of tests/unit/include_rules_test.cpp says the same of includes.
function(parray_room name)
  cmake_parse_arguments(PARSE_ARGV 1 room "" "" "SOURCES;LINKS;PRIVATE")
  if(room_SOURCES)
    add_library(parray_${name} STATIC ${room_SOURCES})
    target_link_libraries(parray_${name} PUBLIC parray_flags ${room_LINKS} PRIVATE ${room_PRIVATE})
    parray_precompiled(parray_${name})
  else()
    add_library(parray_${name} INTERFACE)
    target_link_libraries(parray_${name} INTERFACE parray_flags ${room_LINKS})
  endif()
  add_library(parray::${name} ALIAS parray_${name})
endfunction()

# parray_less_optimised(TARGET...): rooms that read options and write text. Their speed does not matter, and -O1 takes
# a quarter less time to compile. Not for rooms that trace, add up samples, read large files or serve a farm.
function(parray_less_optimised)
  foreach(target ${ARGV})
    target_compile_options(${target} PRIVATE $<$<CONFIG:Release>:-O1>)
  endforeach()
endfunction()

# parray_pages(TARGET): the man pages and shell completion of a program, made by cmake/pages.py whenever the program is
# linked, and installed with it. A program whose help has an example that it does not understand fails to build.
find_package(Python3 COMPONENTS Interpreter)
function(parray_pages target)
  if(PARRAY_SANITIZE)
    return()
  endif()
  if(NOT Python3_Interpreter_FOUND OR CMAKE_CROSSCOMPILING)
    message(STATUS "No man pages and no shell completion of ${target}: they take Python 3 and a build for this machine")
    return()
  endif()
  set(pages ${CMAKE_BINARY_DIR}/pages/${target})
  add_custom_command(TARGET ${target} POST_BUILD VERBATIM
    COMMAND Python3::Interpreter ${CMAKE_SOURCE_DIR}/cmake/pages.py ${CMAKE_SOURCE_DIR}/deploy/MANUAL.md ${pages} $<TARGET_FILE:${target}>)
  set_property(TARGET ${target} APPEND PROPERTY LINK_DEPENDS ${CMAKE_SOURCE_DIR}/cmake/pages.py
    ${CMAKE_SOURCE_DIR}/deploy/MANUAL.md ${CMAKE_SOURCE_DIR}/cli/REFERENCE.md ${CMAKE_SOURCE_DIR}/coordinator/FARM.md)
  install(DIRECTORY ${pages}/ DESTINATION ${CMAKE_INSTALL_DATADIR} COMPONENT ${target})
endfunction()

# Long headers are parsed once for each set of flags that compilers tell apart there. (Kernels get
# none: of an inline function that two sets of instructions share, the linker keeps any copy.)
foreach(flags plain openmp)
  add_library(parray_precompiled_${flags} OBJECT EXCLUDE_FROM_ALL ${CMAKE_SOURCE_DIR}/cmake/precompiled.cpp)
  target_link_libraries(parray_precompiled_${flags} PRIVATE parray_flags nlohmann_json::nlohmann_json)
  target_precompile_headers(parray_precompiled_${flags} PRIVATE ${CMAKE_SOURCE_DIR}/cmake/precompiled.h)
endforeach()
target_link_libraries(parray_precompiled_openmp PRIVATE OpenMP::OpenMP_CXX)

function(parray_precompiled target)
  get_target_property(links ${target} LINK_LIBRARIES)
  if(OpenMP::OpenMP_CXX IN_LIST links)
    target_precompile_headers(${target} REUSE_FROM parray_precompiled_openmp)
  else()
    target_precompile_headers(${target} REUSE_FROM parray_precompiled_plain)
  endif()
endfunction()
