# Writes OUTPUT, a C++ source that contains openapi.json and the files of page/.
# cmake -D SOURCE=coordinator/http -D OUTPUT=FILE.cpp -P embed.cmake
set(types ".html=text/html\; charset=utf-8" ".js=text/javascript\; charset=utf-8" ".css=text/css\; charset=utf-8"
  ".json=application/json" ".svg=image/svg+xml" ".png=image/png" ".ico=image/x-icon" ".woff2=font/woff2"
  ".webmanifest=application/manifest+json")
file(GLOB_RECURSE files RELATIVE ${SOURCE} ${SOURCE}/page/*)
list(SORT files)
set(arrays "")
set(table "")
set(number 0)
foreach(file openapi.json ${files})
  get_filename_component(extension ${file} LAST_EXT)
  set(type "")
  foreach(entry IN LISTS types)
    if(entry MATCHES "^\\${extension}=(.*)$")
      set(type "${CMAKE_MATCH_1}")
    endif()
  endforeach()
  if(NOT type)
    continue()  # not a file for browsers
  endif()
  if(file STREQUAL openapi.json)
    set(path /api/v1/openapi.json)
  else()
    string(REGEX REPLACE "^page" "" path ${file})
    string(REGEX REPLACE "/index.html$" "/" path ${path})
    string(REGEX REPLACE "\\.html$" "" path ${path})
  endif()
  file(READ ${SOURCE}/${file} hex HEX)
  string(REGEX REPLACE "(..)" "\\\\x\\1" bytes "${hex}")
  string(REGEX REPLACE "(................................................................................................................................)" "\\1\"\n\"" bytes "${bytes}")
  string(APPEND arrays "constexpr char bytes_${number}[] =\n\"${bytes}\";\n")
  string(APPEND table "    {\"${path}\", \"${type}\", {bytes_${number}, sizeof(bytes_${number}) - 1}},\n")
  math(EXPR number "${number} + 1")
endforeach()
file(WRITE ${OUTPUT}.new "// Made by embed.cmake.
#include \"coordinator/http/assets.h\"

namespace parray::http {
namespace {
${arrays}
constexpr Asset all[] = {
${table}};
}  // namespace

std::span<const Asset> assets() { return all; }

}  // namespace parray::http
")
file(COPY_FILE ${OUTPUT}.new ${OUTPUT} ONLY_IF_DIFFERENT)
