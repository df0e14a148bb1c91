# cpack runs this script after it has installed the files below a temporary directory, and before it packs them.
cmake_policy(VERSION 3.25)

# Gives files the time of the commit, so that the same source makes the same bytes.
if(NOT DEFINED ENV{SOURCE_DATE_EPOCH})
  execute_process(COMMAND git -C ${CPACK_PARRAY_SOURCE_DIR} log -1 --format=%ct
    OUTPUT_VARIABLE epoch OUTPUT_STRIP_TRAILING_WHITESPACE ERROR_QUIET)
  if(epoch)
    set(ENV{SOURCE_DATE_EPOCH} ${epoch})
  endif()
endif()

# zipped(INPUT OUTPUT): compresses a file. Leaves out its name and time, which would differ.
function(zipped input output)
  execute_process(COMMAND gzip -9nc ${input} OUTPUT_FILE ${output} COMMAND_ERROR_IS_FATAL ANY)
endfunction()

# Moves the man page or completion of a program (parray-worker.1, _parray-worker) to the program's package.
function(move_to_its_package file)
  get_filename_component(stem ${file} NAME_WE)
  string(REGEX REPLACE "^_" "" stem ${stem})
  if(stem IN_LIST CPACK_COMPONENTS_ALL AND NOT stem STREQUAL parray)
    string(REPLACE /parray/usr/ /${stem}/usr/ target ${file})
    get_filename_component(directory ${target} DIRECTORY)
    file(MAKE_DIRECTORY ${directory})
    file(RENAME ${file} ${target})
  endif()
endfunction()

# Writes the files in share/doc that Debian's policy requires.
function(document package root)
  set(doc ${root}/usr/share/doc/${package})
  file(COPY ${CPACK_PARRAY_SOURCE_DIR}/deploy/packages/copyright DESTINATION ${doc} NO_SOURCE_PERMISSIONS)
  zipped(${CPACK_PARRAY_SOURCE_DIR}/CHANGELOG.md ${doc}/changelog.gz)
  string(TIMESTAMP date "%a, %d %b %Y %H:%M:%S +0000" UTC)
  set(plain ${CPACK_TEMPORARY_DIRECTORY}/changelog)
  file(WRITE ${plain} "${package} (${CPACK_PACKAGE_VERSION}-${CPACK_DEBIAN_PACKAGE_RELEASE}) unstable; urgency=medium\n\n"
    "  * See changelog.gz.\n\n -- ${CPACK_PACKAGE_CONTACT}  ${date}\n")
  zipped(${plain} ${doc}/changelog.Debian.gz)
  file(REMOVE ${plain})
endfunction()

function(stage_debian)
  file(GLOB_RECURSE loose ${CPACK_TEMPORARY_DIRECTORY}/parray/usr/share/man/*
    ${CPACK_TEMPORARY_DIRECTORY}/parray/usr/share/*completion*/*)
  foreach(file ${loose})
    move_to_its_package(${file})
  endforeach()
  foreach(package ${CPACK_COMPONENTS_ALL})
    set(root ${CPACK_TEMPORARY_DIRECTORY}/${package})
    document(${package} ${root})
    file(GLOB_RECURSE pages ${root}/usr/share/man/*.[1-9])
    foreach(page ${pages})
      zipped(${page} ${page}.gz)
      file(REMOVE ${page})
    endforeach()
    file(GLOB programs ${root}/usr/bin/* ${root}/usr/lib/parray/*)
    foreach(program ${programs})
      file(RPATH_REMOVE FILE ${program})  # packages use the libraries of the system
    endforeach()
  endforeach()
endfunction()

# Copies libraries to the folder of the modules, and the licences of their packages. Leaves out the C library and MPI,
# which must be those of the machine.
function(bundle root)
  set(target ${root}/lib/parray)
  file(GLOB programs ${root}/bin/*)
  file(GLOB modules ${target}/*.so)
  file(GET_RUNTIME_DEPENDENCIES EXECUTABLES ${programs} MODULES ${modules}
    RESOLVED_DEPENDENCIES_VAR libraries UNRESOLVED_DEPENDENCIES_VAR missing
    PRE_EXCLUDE_REGEXES "^(ld-linux.*|lib(c|m|dl|pthread|rt|resolv|mvec))\\.so\\." "^lib(mpi|open-rte|open-pal)\\.so\\.")
  if(missing)
    message(FATAL_ERROR "this machine lacks libraries that the tarball needs: ${missing}")
  endif()
  foreach(library ${libraries})
    get_filename_component(name ${library} NAME)
    file(REAL_PATH ${library} file)
    file(COPY_FILE ${file} ${target}/${name})
    file(CHMOD ${target}/${name} PERMISSIONS OWNER_READ OWNER_WRITE GROUP_READ WORLD_READ)
    file(RPATH_REMOVE FILE ${target}/${name})
    list(APPEND files ${file})
  endforeach()
  execute_process(COMMAND dpkg-query -S ${files} OUTPUT_VARIABLE owners ERROR_QUIET)
  string(REGEX MATCHALL "[^\n:]+:[^\n]+\n" owners "${owners}")
  foreach(owner ${owners})
    string(REGEX REPLACE ":.*" "" owner ${owner})
    if(EXISTS /usr/share/doc/${owner}/copyright)
      file(REAL_PATH /usr/share/doc/${owner}/copyright licence)
      file(MAKE_DIRECTORY ${root}/share/doc/parray/licences)
      file(COPY_FILE ${licence} ${root}/share/doc/parray/licences/${owner})
    endif()
  endforeach()
endfunction()

if(CPACK_GENERATOR STREQUAL DEB)
  stage_debian()
else()
  bundle(${CPACK_TEMPORARY_DIRECTORY})
endif()
