// The scene of a job, which denoising and labels need: kept and sent by the coordinator.
#include <doctest/doctest.h>

#include "common/scene/scene_bytes.h"
#include "common/scene/settings.h"
#include "tests/support/crash_store.h"
#include "tests/support/rooms.h"
#include "tests/support/service.h"

namespace parray::test {
namespace {

JobId submit_denoised(Service& service, bool denoise, const std::string& drawing = {}) {
  RenderSettings settings = many_leases();
  settings.replicates = true;
  msg::Submit submit = service.submission(small_scene(), settings);
  submit.denoise = denoise;
  submit.drawing = drawing;
  return service.ask<msg::Submitted>(submit).job;
}

}  // namespace

TEST_CASE("the coordinator keeps and sends the scene of a done job that is denoised or drawn on") {
  CrashStore store(0, 1);
  for (Store* kept_in : {static_cast<Store*>(nullptr), static_cast<Store*>(&store)}) {
    Service service(service_options(), kept_in);
    Hand hand(service, "w");
    const JobId denoised = submit_denoised(service, true);
    const JobId drawn = submit_denoised(service, false, "{}");
    const JobId plain = submit_denoised(service, false);
    for (const JobId id : {denoised, drawn, plain}) work(service, {{&hand, honest}}, id);
    CHECK(service.job(denoised).at("denoise") == true);
    CHECK(service.job(drawn).at("drawn") == true);
    CHECK(service.job(plain).at("denoise") == false);
    CHECK_FALSE(service.job(plain).contains("drawn"));
    for (const JobId id : {denoised, drawn}) {
      const auto sent = service.ask<msg::SceneData>(msg::FetchScene{1, id});
      CHECK(scene_identity(*sent.scene.scene()) == scene_identity(small_scene()));
      CHECK(sent.drawing == (id == drawn ? "{}" : ""));
    }
    CHECK(service.refusal(msg::FetchScene{1, plain}).find("no longer keeps the scene") !=
          std::string::npos);
    CHECK(service.refusal(msg::FetchScene{1, 999}) != "");
  }
}

TEST_CASE("a denoised job needs the halves of its samples") {
  Service service;
  msg::Submit submit = service.submission(small_scene(), many_leases());
  submit.denoise = true;
  CHECK(service.refusal(submit).find("`replicates`") != std::string::npos);
}

}  // namespace parray::test
