# parray_room(NAME [SOURCES FILE...] [LINKS TARGET...] [PRIVATE TARGET...]): makes the library parray_NAME, alias
# parray::NAME, of a room. Each room is a separate library, so that a program links only the rooms that it uses.
# Headers of the room may include the rooms and libraries in LINKS; sources may also include those in PRIVATE. The table
# in tests/unit/include_rules_test.cpp has the same rules for includes.
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

# parray_pages(TARGET): makes the man pages and shell completion of a program with cmake/pages.py whenever it is linked,
# and installs them. The build fails if the program does not understand an example of its own help.
find_package(Python3 COMPONENTS Interpreter)
function(parray_pages target)
  if(PARRAY_SANITIZE)
    return()
  endif()
  if(NOT Python3_Interpreter_FOUND OR CMAKE_CROSSCOMPILING)
    message(STATUS "Without man pages and shell completion of ${target}: they need Python 3 and a build for this machine")
    return()
  endif()
  set(pages ${CMAKE_BINARY_DIR}/pages/${target})
  add_custom_command(TARGET ${target} POST_BUILD VERBATIM
    COMMAND Python3::Interpreter ${CMAKE_SOURCE_DIR}/cmake/pages.py ${CMAKE_SOURCE_DIR}/deploy/MANUAL.md ${pages} $<TARGET_FILE:${target}>)
  set_property(TARGET ${target} APPEND PROPERTY LINK_DEPENDS ${CMAKE_SOURCE_DIR}/cmake/pages.py
    ${CMAKE_SOURCE_DIR}/deploy/MANUAL.md ${CMAKE_SOURCE_DIR}/cli/REFERENCE.md ${CMAKE_SOURCE_DIR}/coordinator/FARM.md)
  install(DIRECTORY ${pages}/ DESTINATION ${CMAKE_INSTALL_DATADIR} COMPONENT ${target})
endfunction()

# Precompiles long headers once with and once without OpenMP, because compilers require the same flags. Kernels use no
# precompiled header: the linker keeps an arbitrary copy of an inline function that two instruction sets share.
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
