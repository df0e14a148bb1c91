// In http_face.cpp's place where cpp-httplib is missing (PARRAY_HTTP=OFF).
#include "common/base/error.h"
#include "coordinator/http/http_face.h"

namespace parray::http {

class HttpFace::Impl {};

HttpFace::HttpFace(const Options& /*options*/, InprocHub& /*hub*/,
                   std::shared_ptr<spdlog::logger> /*log*/) {
  throw InputError(
      "--http: this parray-coordinator was built without: install libcpp-httplib-dev and build it "
      "again");
}
HttpFace::~HttpFace() = default;
void HttpFace::serve_text(const std::string& /*path*/, const std::string& /*type*/,
                          std::function<std::string()> /*text*/) {}
void HttpFace::start() {}
const std::string& HttpFace::address() const {
  static const std::string none;
  return none;
}

}  // namespace parray::http
