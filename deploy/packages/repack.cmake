# cpack runs this script on the packages that it has made. Their archives list files in the arbitrary order of the
# directory. This script sorts the files by name, so that the packages have the same bytes on every machine.
cmake_policy(VERSION 3.25)

function(repack_debian file)
  set(tree ${file}.tree)
  execute_process(COMMAND dpkg-deb --raw-extract ${file} ${tree} COMMAND_ERROR_IS_FATAL ANY)
  execute_process(COMMAND sort -k 2 -o ${tree}/DEBIAN/md5sums ${tree}/DEBIAN/md5sums COMMAND_ERROR_IS_FATAL ANY)
  execute_process(COMMAND dpkg-deb --root-owner-group --build ${tree} ${file} OUTPUT_QUIET COMMAND_ERROR_IS_FATAL ANY)
  file(REMOVE_RECURSE ${tree})
endfunction()

function(repack_tarball file)
  get_filename_component(directory ${CPACK_TEMPORARY_DIRECTORY} DIRECTORY)
  get_filename_component(name ${CPACK_TEMPORARY_DIRECTORY} NAME)
  execute_process(COMMAND tar -C ${directory} --sort=name --mtime=@$ENV{SOURCE_DATE_EPOCH} --owner=0 --group=0
    --numeric-owner -cf - ${name} COMMAND gzip -6n OUTPUT_FILE ${file} COMMAND_ERROR_IS_FATAL ANY)
endfunction()

foreach(file ${CPACK_PACKAGE_FILES})
  if(CPACK_GENERATOR STREQUAL DEB)
    repack_debian(${file})
  else()
    repack_tarball(${file})
  endif()
endforeach()
