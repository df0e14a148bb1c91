# Packages, which cpack writes to packages/ of the build directory. `cpack -G DEB` makes a package for each role from
# the component of the same name. `cpack -G TGZ` makes one tarball of everything, with libraries.
set(packages ${CMAKE_CURRENT_LIST_DIR})

set(CPACK_PACKAGE_NAME parray)
set(CPACK_PACKAGE_VENDOR "The ParRay authors")
set(CPACK_PACKAGE_CONTACT "The ParRay authors <parray@example.org>")
set(CPACK_PACKAGE_FILE_NAME parray-${PROJECT_VERSION}-linux-${CMAKE_SYSTEM_PROCESSOR})
set(CPACK_PACKAGE_DIRECTORY ${CMAKE_BINARY_DIR}/packages)  # cpack -B sets another directory
set(CPACK_STRIP_FILES ON)
set(CPACK_VERBATIM_VARIABLES ON)
set(CPACK_PARRAY_SOURCE_DIR ${CMAKE_SOURCE_DIR})
set(CPACK_PRE_BUILD_SCRIPTS ${packages}/stage.cmake)
set(CPACK_POST_BUILD_SCRIPTS ${packages}/repack.cmake)

set(CPACK_COMPONENTS_ALL parray-worker)
if(NOT PARRAY_WORKER_ONLY)
  list(PREPEND CPACK_COMPONENTS_ALL parray parray-coordinator)
endif()
if(TARGET parray-mpi)
  list(APPEND CPACK_COMPONENTS_ALL parray-mpi)
endif()
set(CPACK_COMPONENTS_GROUPING IGNORE)

set(CPACK_DEB_COMPONENT_INSTALL ON)
set(CPACK_DEBIAN_FILE_NAME DEB-DEFAULT)
set(CPACK_DEBIAN_PACKAGE_RELEASE 1)
set(CPACK_DEBIAN_PACKAGE_SECTION graphics)
set(CPACK_DEBIAN_PACKAGE_SHLIBDEPS ON)
set(CPACK_DEBIAN_PACKAGE_CONTROL_STRICT_PERMISSION ON)
set(CPACK_DEBIAN_ENABLE_COMPONENT_DEPENDS ON)

foreach(package ${CPACK_COMPONENTS_ALL})
  string(TOUPPER ${package} key)
  set(CPACK_DEBIAN_${key}_PACKAGE_NAME ${package})
endforeach()

# service(PACKAGE OTHER): adds unit, configuration and scripts to PACKAGE. OTHER is the package of the other service.
# `PURGED` lists the files that purging the package deletes, `POSTINST` commands that its installation runs.
function(service package other)
  string(REPLACE parray- "" role ${package})
  set(SERVICE ${package}.service)
  set(OTHER ${other})
  file(READ ${packages}/hardening.conf HARDENING)
  set(made ${CMAKE_BINARY_DIR}/deploy/${package})
  configure_file(${packages}/${SERVICE} ${made}/${SERVICE} @ONLY)
  foreach(script postinst prerm postrm)
    configure_file(${packages}/${script}.in ${made}/${script} @ONLY
      FILE_PERMISSIONS OWNER_READ OWNER_WRITE OWNER_EXECUTE GROUP_READ GROUP_EXECUTE WORLD_READ WORLD_EXECUTE)
  endforeach()
  file(WRITE ${made}/conffiles "/etc/parray/${role}.conf\n")
  # EXCLUDE_FROM_ALL: only packages contain these files. cmake --install, whose prefix may be a home directory, leaves
  # them out.
  install(FILES ${made}/${SERVICE} DESTINATION lib/systemd/system COMPONENT ${package} EXCLUDE_FROM_ALL)
  install(FILES ${packages}/${role}.conf DESTINATION /etc/parray COMPONENT ${package} EXCLUDE_FROM_ALL)
  string(TOUPPER ${package} key)
  set(CPACK_DEBIAN_${key}_PACKAGE_DEPENDS adduser PARENT_SCOPE)
  set(CPACK_DEBIAN_${key}_PACKAGE_CONTROL_EXTRA ${made}/postinst ${made}/prerm ${made}/postrm ${made}/conffiles PARENT_SCOPE)
endfunction()

set(PURGED "/var/lib/parray /etc/parray/keys")
set(POSTINST "# The user parray makes the farm's keys there with parray keygen.
install -d -o parray -g parray -m 700 /etc/parray/keys")
service(parray-coordinator parray-worker)
set(PURGED "/etc/parray/worker.key")
set(POSTINST "")
service(parray-worker parray-coordinator)
# The package parray contains the reader of scenes for the HTTP interface. Only a coordinator with --http needs it.
set(CPACK_DEBIAN_PARRAY-COORDINATOR_PACKAGE_RECOMMENDS parray)
set(CPACK_DEBIAN_PARRAY_PACKAGE_DEPENDS fonts-dejavu-core)  # for labels
set(CPACK_DEBIAN_PARRAY_PACKAGE_SUGGESTS "ffmpeg, gnuplot-nox, python3")  # films, tradeoff's plots, scenes/generate
# The package parray contains the modules that read and write pictures.
set(CPACK_COMPONENT_PARRAY-MPI_DEPENDS parray)
set(CPACK_DEBIAN_PARRAY-MPI_PACKAGE_DEPENDS openmpi-bin)

set(CPACK_PACKAGE_DESCRIPTION_SUMMARY "")  # each package has its own
set(CPACK_COMPONENT_PARRAY_DESCRIPTION "path tracer of spheres with stated errors
ParRay renders scenes of spheres, such as molecules, grains and stars. A
picture has the same bits on any machine and on any number of machines, and
states its error. This package contains the program parray, which renders on
this machine and submits jobs to a farm, and some scenes.")
set(CPACK_COMPONENT_PARRAY-COORDINATOR_DESCRIPTION "path tracer of spheres: coordinator of a render farm
The service that owns the jobs of a farm. It leases their work to workers and
stores the results in /var/lib/parray. Without keys it serves only its own
machine.")
set(CPACK_COMPONENT_PARRAY-WORKER_DESCRIPTION "path tracer of spheres: worker of a render farm
The service that traces for a coordinator on the same or on another machine.")
set(CPACK_COMPONENT_PARRAY-MPI_DESCRIPTION "path tracer of spheres: one picture by all ranks of an mpirun
The program that renders a picture with all ranks of an MPI job. It needs no
coordinator and no workers. The picture has the same bits as with parray.")

include(CPack)
