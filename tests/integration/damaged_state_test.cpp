// Damaged, truncated and missing files of the state: what clients are told, and that all else
// works.
#include <doctest/doctest.h>

#include <filesystem>
#include <fstream>
#include <optional>
#include <string>

#include "common/scene/settings.h"
#include "coordinator/jobs/picture_file.h"
#include "coordinator/replica/replica.h"
#include "coordinator/replica/replicated_store.h"
#include "coordinator/store/disk_store.h"
#include "tests/support/contains.h"
#include "tests/support/rooms.h"
#include "tests/support/service.h"
#include "tests/support/temporary_directory.h"

namespace parray::test {
namespace {

namespace fs = std::filesystem;

enum class Damage : std::uint8_t { flipped, cut, gone };

void damage(const fs::path& file, Damage how) {
  switch (how) {
    case Damage::flipped: {
      std::fstream out(file, std::ios::in | std::ios::out | std::ios::binary);
      const auto middle = static_cast<std::streamoff>(fs::file_size(file) / 2);
      out.seekg(middle);
      const char byte = static_cast<char>(out.get());
      out.seekp(middle);
      out.put(static_cast<char>(byte ^ 1));
      return;
    }
    case Damage::cut: fs::resize_file(file, fs::file_size(file) / 2); return;
    case Damage::gone: fs::remove(file);
  }
}

/// A standby that is always there.
class NearStandby final : public ReplicaConnection {
 public:
  explicit NearStandby(Store& store) : replica_(store) {}
  std::optional<ReplicaReply> call(ReplicaRequest request) override {
    request.number = ++number_;
    return decode_reply(replica_.answer(encode(request)));
  }
  [[nodiscard]] bool session_lost() const override { return false; }
  [[nodiscard]] const std::string& address() const override { return address_; }

 private:
  Replica replica_;
  std::uint64_t number_ = 0;
  std::string address_ = "standby";
};

/// Two finished jobs with their state on a disk and at a standby.
struct DoneJobs {
  explicit DoneJobs(bool with_standby)
      : service(service_options(), with_standby ? static_cast<Store*>(&replicated) : &disk) {
    Hand ann(service, "ann");
    for (JobId* job : {&damaged, &whole}) {
      *job = service.submit(small_scene(), many_leases());
      work(service, {{&ann, honest}}, *job);
      REQUIRE(service.state(*job) == "done");
    }
  }
  [[nodiscard]] static fs::path picture(const fs::path& state, JobId job) {
    return state / "jobs" / std::to_string(job) / "picture";
  }
  std::string flag() { return service.job(damaged).at("flag"); }
  std::string sha256(JobId job) { return service.sha256(job); }

  TemporaryDirectory directory;
  DiskStore disk{directory.path() / "here"};
  DiskStore copy{directory.path() / "there"};
  NearStandby line{copy};
  std::uint64_t numbers = 0;
  ReplicatedStore replicated{disk, line, [this] { return ++numbers; }};
  Service service;
  JobId damaged = 0;
  JobId whole = 0;
};

const std::string expected = reference_sha256(small_scene(), many_leases());

}  // namespace

TEST_CASE(
    "a damaged, truncated or missing picture causes an error and a flag, and all else works") {
  for (const Damage how : {Damage::flipped, Damage::cut, Damage::gone}) {
    CAPTURE(static_cast<int>(how));
    DoneJobs jobs(false);
    Service& service = jobs.service;
    damage(DoneJobs::picture(jobs.directory.path() / "here", jobs.damaged), how);
    const auto error = service.ask<msg::Error>(msg::Fetch{1, jobs.damaged, false, false});
    CHECK(error.status == 1);
    CHECK(contains(error.message, "is damaged"));
    CHECK(contains(service.ask<msg::Error>(msg::FetchJournal{2, jobs.damaged}).message,
                   "is damaged"));
    CHECK(contains(jobs.flag(), "is damaged: put it back"));
    CHECK(jobs.sha256(jobs.whole) == expected);
    service.restart();
    CHECK(contains(jobs.flag(), "is damaged: put it back"));
    CHECK(service.job(jobs.whole).at("flag") == "");
  }
}

TEST_CASE("a damaged, truncated or missing picture is restored from the standby") {
  for (const Damage how : {Damage::flipped, Damage::cut, Damage::gone}) {
    CAPTURE(static_cast<int>(how));
    DoneJobs jobs(true);
    damage(DoneJobs::picture(jobs.directory.path() / "here", jobs.damaged), how);
    CHECK(jobs.sha256(jobs.damaged) == expected);
    CHECK(contains(jobs.flag(), "restored from the standby"));
    damage(DoneJobs::picture(jobs.directory.path() / "there", jobs.damaged), Damage::gone);
    CHECK(jobs.sha256(jobs.damaged) == expected);  // it is kept here
    CHECK(contains(jobs.flag(), "restored from the standby"));
    CHECK(position_of(jobs.disk, *replication_state_of(jobs.disk))
              .has_value());  // both are still in step
  }
}

TEST_CASE("a picture that is damaged at the primary and at the standby causes an error") {
  DoneJobs jobs(true);
  damage(DoneJobs::picture(jobs.directory.path() / "here", jobs.damaged), Damage::cut);
  damage(DoneJobs::picture(jobs.directory.path() / "there", jobs.damaged), Damage::cut);
  CHECK(jobs.sha256(jobs.damaged) == "no picture");
  CHECK(contains(jobs.flag(), "is damaged: put it back"));
}

TEST_CASE("the flag of a picture's file is removed when the file is back, and other flags remain") {
  const PictureFile damaged{{}, "picture is damaged", false};
  const PictureFile restored{"bytes", "picture is damaged", true};
  const PictureFile good{"bytes", "", false};
  for (const std::string other : {"", "worker 'ann' returned wrong bits"}) {
    CAPTURE(other);
    const std::string flag = flag_with(other, damaged);
    CHECK(flag.starts_with(other));
    CHECK(contains(flag, "is damaged"));
    CHECK(flag_with(flag, damaged) == flag);
    CHECK(flag_with(flag, good) == other);
    CHECK(contains(flag_with(flag, restored), "restored"));
    CHECK_FALSE(contains(flag_with(flag, restored), "put it back"));
    CHECK(flag_with(flag_with(flag, restored), good) == flag_with(flag, restored));
  }
}

TEST_CASE("a damaged scene fails its job, and damaged rows are traced again") {
  for (const std::string file : {"scene", "rows"}) {
    for (const Damage how : {Damage::flipped, Damage::cut, Damage::gone}) {
      CAPTURE(file);
      CAPTURE(static_cast<int>(how));
      TemporaryDirectory directory;
      RenderSettings settings = many_leases();
      JobId bad = 0;
      {
        DiskStore store(directory.path());
        Service service(service_options(), &store);
        Hand ann(service, "ann");
        bad = service.submit(small_scene(), settings);
        work(service, {{&ann, honest}}, bad, 3);
        REQUIRE(service.state(bad) == "running");
      }
      DiskStore store(directory.path());
      Service service(service_options(), &store);
      const fs::path rows = directory.path() / "jobs" / std::to_string(bad) / "rows";
      damage(file == "rows" ? rows : fs::directory_iterator(directory.path() / "scenes")->path(),
             how);
      Hand ann(service, "ann");
      work(service, {{&ann, honest}}, bad);
      if (file == "scene") {
        CHECK(service.state(bad) == "failed");
        CHECK(contains(service.job(bad).at("reason"), "preparing the job"));
      } else {
        CHECK(service.state(bad) == "done");
        CHECK(service.sha256(bad) == expected);
        CHECK(contains(service.job(bad).at("events").dump(), "stored results are damaged"));
      }
    }
  }
}

}  // namespace parray::test
