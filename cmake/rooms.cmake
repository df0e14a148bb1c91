# parray_room(NAME [COLD] [SOURCES FILE...] [LINKS TARGET...] [PRIVATE TARGET...]): makes the library parray_NAME, alias
# parray::NAME, of a room. Each room is a separate library, so that a program links only the rooms that it uses.
# Headers of the room may include the rooms and libraries in LINKS; sources may also include those in PRIVATE. The table
# in tests/unit/include_rules_test.cpp has the same rules for includes. COLD: its code is cold, see parray_compiled.
function(parray_room name)
  cmake_parse_arguments(PARSE_ARGV 1 room "COLD" "" "SOURCES;LINKS;PRIVATE")
  if(room_SOURCES)
    add_library(parray_${name} STATIC ${room_SOURCES})
    target_link_libraries(parray_${name} PUBLIC parray_flags ${room_LINKS} PRIVATE ${room_PRIVATE})
    if(room_COLD)
      parray_compiled(parray_${name} cold)
    else()
      parray_compiled(parray_${name} hot)
    endif()
  else()
    add_library(parray_${name} INTERFACE)
    target_link_libraries(parray_${name} INTERFACE parray_flags ${room_LINKS})
  endif()
  add_library(parray::${name} ALIAS parray_${name})
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

# Cold code is called rarely or waits for others: it reads options, writes text, or decides once per message. -Og
# compiles it in two thirds of the time of -O2. Code that visits each pixel, sphere or particle is hot.
set(hot_flags)
set(cold_flags $<$<CONFIG:Release>:-Og>)
# Precompiles long headers for each, because compilers require the same flags. Kernels use no precompiled header: the
# linker keeps an arbitrary copy of an inline function that two instruction sets share.
foreach(heat hot cold)
  add_library(parray_precompiled_${heat} OBJECT EXCLUDE_FROM_ALL ${CMAKE_SOURCE_DIR}/cmake/precompiled.cpp)
  target_link_libraries(parray_precompiled_${heat} PRIVATE parray_flags OpenMP::OpenMP_CXX nlohmann_json::nlohmann_json)
  target_compile_options(parray_precompiled_${heat} PRIVATE ${${heat}_flags})
  target_precompile_headers(parray_precompiled_${heat} PRIVATE ${CMAKE_SOURCE_DIR}/cmake/precompiled.h)
endforeach()

# parray_compiled(TARGET HEAT): compiles the sources of a library or program as hot or cold code (HEAT: hot or cold).
function(parray_compiled target heat)
  target_compile_options(${target} PRIVATE ${OpenMP_CXX_FLAGS} ${${heat}_flags})  # as the precompiled headers
  target_precompile_headers(${target} REUSE_FROM parray_precompiled_${heat})
endfunction()
