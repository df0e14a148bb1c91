#include <httplib.h>

#include <memory>

#include "coordinator/http/webhooks.h"

namespace parray::http {

bool post_webhook(const WebhookUrl& url, const std::string& body) {
  // httplib::Client does not accept IPv6 addresses.
  const std::unique_ptr<httplib::ClientImpl> client =
      url.secure ? std::make_unique<httplib::SSLClient>(url.host, url.port)
                 : std::make_unique<httplib::ClientImpl>(url.host, url.port);
  client->set_connection_timeout(5);
  client->set_read_timeout(10);
  client->set_write_timeout(10);
  client->set_follow_location(false);
  const httplib::Result result =
      client->Post(url.path, {{"Host", url.authority}, {"User-Agent", "ParRay/" PARRAY_VERSION}},
                   body, "application/json");
  return result && result->status >= 200 && result->status < 300;
}

}  // namespace parray::http
