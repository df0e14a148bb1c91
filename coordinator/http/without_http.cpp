// In http_service.cpp's place where cpp-httplib is missing (PARRAY_HTTP=OFF).
#include "common/base/error.h"
#include "coordinator/http/http_service.h"

namespace parray::http {

class HttpService::Impl {};

HttpService::HttpService(const Options& /*options*/, InprocHub& /*hub*/,
                         std::shared_ptr<spdlog::logger> /*log*/) {
  throw InputError(
      "--http: this parray-coordinator was built without: install libcpp-httplib-dev and build it "
      "again");
}
HttpService::~HttpService() = default;
void HttpService::serve_text(const std::string& /*path*/, const std::string& /*type*/,
                             std::function<std::string()> /*text*/) {}
void HttpService::start() {}
const std::string& HttpService::address() const {
  static const std::string none;
  return none;
}

}  // namespace parray::http
