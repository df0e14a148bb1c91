#pragma once

#include <doctest/doctest.h>

#include <cstdint>
#include <memory>
#include <string>

#include "common/scene/settings.h"
#include "tests/support/contains.h"
#include "tests/support/rooms.h"
#include "tests/support/service.h"

namespace parray::test {

/// Returns options of a coordinator that lets a second machine check a share of all leases.
inline CoordinatorOptions with_checks(double share) {
  CoordinatorOptions options = service_options();
  options.checks.share = share;
  return options;
}

/// Checks that only these machines are in quarantine, and that the picture is right.
inline void check_right(Service& service, JobId job, const RenderSettings& settings,
                        const Hands& hands, const std::string& faulty_workers) {
  REQUIRE(service.state(job) == "done");
  CHECK(service.sha256(job) == reference_sha256(small_scene(), settings));
  for (const auto& [hand, manner] : hands) {
    const std::string& name = hand->name();
    CAPTURE(name);
    const bool lies = contains(name, faulty_workers);
    CHECK((lies || service.worker(name).at("state") == "ready"));
  }
}

inline RenderSettings of_height(std::uint32_t height) {
  RenderSettings settings = many_leases();
  settings.height = height;
  return settings;
}

/// Returns the same wrong result as the others in one of `leases` leases.
inline Manner lying_rarely(std::uint64_t one_in, std::uint64_t seed) {
  return [one_in, dice = std::make_shared<Dice>(seed)](Hand& hand, const msg::Grant& grant) {
    dice->one_in(one_in) ? hand.send_wrong(grant) : hand.send_honest(grant);
  };
}

}  // namespace parray::test
