// Replaces http_service.cpp in a build with PARRAY_HTTP=OFF, the default if cpp-httplib is missing.
#include "common/base/error.h"
#include "coordinator/http/http_service.h"

namespace parray::http {

HttpService serve_http(const Options& /*options*/, InprocHub& /*hub*/,
                       const std::shared_ptr<spdlog::logger>& /*log*/) {
  throw InputError(
      "--http: this program was built without HTTP: install libcpp-httplib-dev, and build ParRay "
      "again with -DPARRAY_HTTP=ON");
}

}  // namespace parray::http
