#pragma once

#include <atomic>
#include <memory>
#include <string>
#include <thread>
#include <utility>

#include "coordinator/http/loop_client.h"
#include "coordinator/loop/coordinator.h"
#include "proto/actor.h"
#include "proto/inproc_link.h"
#include "tests/support/rooms.h"
#include "tests/support/service.h"

namespace parray::test {

/// A coordinator's loop that runs in its own thread.
class RunningLoop {
 public:
  explicit RunningLoop(const CoordinatorOptions& options = service_options())
      : coordinator_(options, nullptr, std::make_shared<spdlog::logger>("silent")), thread_([this] {
          const SteadyClock clock;
          run_actor(coordinator_, hub_.coordinator(), clock, [this](Time) { return stop_.load(); });
        }) {}
  ~RunningLoop() {
    stop_ = true;
    thread_.join();
  }
  RunningLoop& operator=(RunningLoop&&) = delete;
  InprocHub& hub() { return hub_; }

 private:
  InprocHub hub_;
  Coordinator coordinator_;
  std::atomic<bool> stop_ = false;
  std::thread thread_;
};

/// Submits a small scene, and returns the job's number.
inline JobId submit_to(LoopClient& client, const std::string& token) {
  msg::Submit submit;
  submit.token = token;
  submit.name = "scene";
  submit.settings = small_settings(small_scene());
  submit.scene = ScenePayload(std::make_shared<const Scene>(small_scene()));
  return client.ask<msg::Submitted>({}, std::move(submit)).job;
}

}  // namespace parray::test
