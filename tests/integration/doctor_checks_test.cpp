// The checks of `parray doctor`: each passes on this machine, and each detects its fault.
#include <doctest/doctest.h>
#include <sys/stat.h>

#include <array>
#include <atomic>
#include <cmath>
#include <fstream>
#include <limits>
#include <set>
#include <sstream>
#include <stdexcept>
#include <string>
#include <thread>
#include <utility>

#include "cli/check/doctor/check.h"
#include "cli/check/doctor/extremes.h"
#include "cli/check/doctor/machine.h"
#include "cli/check/doctor/messages.h"
#include "cli/check/doctor/tracing.h"
#include "cli/child_process/child_process.h"
#include "cli/output/processor.h"
#include "common/base/error.h"
#include "common/math/float_mode.h"
#include "common/process/stop_signal.h"
#include "common/scene/settings.h"
#include "common/trace/isa.h"
#include "tests/support/message_of.h"
#include "tests/support/rooms.h"
#include "tests/support/temporary_directory.h"

namespace parray {
namespace {

namespace fs = std::filesystem;
using test::TemporaryDirectory;

const TracerMaker honest = tracers_of(Isa::automatic);

/// Traces like another tracer, then changes the result.
class LyingTracer final : public PathTracer {
 public:
  using Lie = std::function<void(std::span<PixelSums>, TraceCounts&)>;
  LyingTracer(std::unique_ptr<PathTracer> tracer, Lie lie)
      : PathTracer(tracer->accelerator()), tracer_(std::move(tracer)), lie_(std::move(lie)) {}

  void trace_run(const PixelRun& run, const RunSamples& samples, std::span<PixelSums> sums,
                 TraceCounts& counts) const override {
    tracer_->trace_run(run, samples, sums, counts);
    if (run.y == 3) lie_(sums, counts);
  }
  void first_hits(const PixelRun& run, const SampleRange& samples,
                  std::span<FirstHit> hits) const override {
    tracer_->first_hits(run, samples, hits);
  }
  void add_sky_samples(const PixelRun& run, const RunSamples& samples,
                       std::span<SkySamples> sky) const override {
    tracer_->add_sky_samples(run, samples, sky);
  }

 private:
  std::unique_ptr<PathTracer> tracer_;
  Lie lie_;
};

/// Tracers that are wrong in one precision with one accelerator.
TracerMaker lying(Precision precision, AcceleratorKind accelerator, const LyingTracer::Lie& lie) {
  return [=](const Scene& scene, const RenderSettings& settings) -> std::unique_ptr<PathTracer> {
    auto tracer = honest(scene, settings);
    if (settings.precision != precision || settings.accelerator != accelerator) return tracer;
    return std::make_unique<LyingTracer>(std::move(tracer), lie);
  };
}

void lose_a_little_light(std::span<PixelSums> sums, TraceCounts& /*counts*/) { --sums[1].sum[2]; }
void leak_a_little_light(std::span<PixelSums> sums, TraceCounts& /*counts*/) { ++sums[1].sum[0]; }
void take_one_more_ray(std::span<PixelSums> /*sums*/, TraceCounts& counts) { ++counts.rays; }

fs::path script(const fs::path& directory, const std::string& name, const std::string& lines) {
  fs::path file = directory / name;
  std::ofstream(file) << "#!/bin/sh\n" << lines << "\n";
  chmod(file.c_str(), 0755);
  return file;
}

/// Returns whether the process with the number in a file has ended, or is a zombie.
bool gone(const fs::path& file) {
  int pid = 0;
  std::ifstream(file) >> pid;
  REQUIRE(pid > 1);
  std::ifstream stat("/proc/" + std::to_string(pid) + "/stat");
  std::string word;
  for (int i = 0; i < 3; ++i) stat >> word;
  return !stat || word == "Z";
}

}  // namespace

TEST_CASE("a check that throws is a failure under its name, but an interrupt passes through") {
  const CheckResult found = run({"disk", []() -> CheckResult { throw RunError("no space"); }});
  CHECK(found.name == "disk");
  CHECK(found.status == CheckStatus::failed);
  CHECK(found.detail == "no space");
  CHECK_FALSE(found.remedy.empty());
  CHECK_THROWS_AS(run({"disk", []() -> CheckResult { throw Interrupted(); }}), Interrupted);
}

TEST_CASE("a float mode other than that of IEEE 754 causes a warning that names the difference") {
  const auto of = [](unsigned control) {
    return check_float_mode(std::array{float_control::ieee, control, float_control::ieee});
  };
  CHECK(of(float_control::ieee).status == CheckStatus::ok);
#if defined(__x86_64__)
  CHECK(of(float_control::ieee | 0x3F).status == CheckStatus::ok);  // exceptions that have happened
#endif
  constexpr unsigned lowest = float_control::rounding & -float_control::rounding;
  for (const auto& [bits, word] :
       {std::pair{float_control::denormal_results, "results"},
        std::pair{float_control::denormal_operands, "operands"},
        std::pair{float_control::rounding, "rounding"}, std::pair{lowest, "rounding"},
        std::pair{float_control::exceptions, "exceptions"}}) {
    const unsigned control = float_control::ieee ^ bits;
    CHECK(of(control).status == CheckStatus::warning);
    CHECK(of(control).detail.find(word) != std::string::npos);
    CHECK(of(control).detail.find("1 of 3 threads") != std::string::npos);
  }
}

TEST_CASE("a fast mode of the current thread is detected, and rounding is right nevertheless") {
  const FloatMode restored;
  float_control::write(float_control::ieee | float_control::denormal_results |
                       float_control::denormal_operands);
  CHECK(check_float_mode().status == CheckStatus::warning);
  CHECK(check_rounding().status == CheckStatus::ok);
}

TEST_CASE("hard cases of rounding are right on this machine, and one wrong bit is a failure") {
  CHECK(check_rounding().status == CheckStatus::ok);
  auto singles = single_cases;
  singles[7].result ^= 1;
  CHECK(check_rounding(singles, double_cases).status == CheckStatus::failed);
  auto doubles = double_cases;
  doubles.back().result ^= 1;
  CHECK(check_rounding(single_cases, doubles).status == CheckStatus::failed);
}

TEST_CASE("every instruction set of this machine passes every check of tracing") {
  for (const Isa isa : instruction_sets()) {
    const TracerMaker make = tracers_of(isa);
    for (const CheckResult& found :
         {check_picture(make), check_furnaces(make), check_self_hits(make), check_scaling(make)}) {
      CHECK_MESSAGE(found.status == CheckStatus::ok, found.detail);
    }
  }
}

TEST_CASE("a fingerprint other than the expected one is a failure") {
  const CheckResult found = check_picture(honest, std::string(64, '0'));
  CHECK(found.status == CheckStatus::failed);
  CHECK(found.detail.find(pinned_fingerprint.substr(0, 16)) != std::string::npos);
}

TEST_CASE(
    "a tracer that is wrong by one unit in one precision and accelerator is found and named") {
  for (const Precision precision : {Precision::f32, Precision::mixed, Precision::f64}) {
    for (const AcceleratorKind kind : {AcceleratorKind::linear, AcceleratorKind::bvh}) {
      const std::string name = std::string(name_of(precision)) + " " + std::string(name_of(kind));
      const TracerMaker dark = lying(precision, kind, lose_a_little_light);
      CHECK(check_picture(dark).status == CheckStatus::failed);
      for (const CheckResult& found :
           {check_furnaces(dark), check_furnaces(lying(precision, kind, leak_a_little_light)),
            check_self_hits(dark), check_self_hits(lying(precision, kind, take_one_more_ray)),
            check_scaling(dark)}) {
        CHECK(found.status == CheckStatus::failed);
        CHECK_MESSAGE(found.detail.find(name) != std::string::npos, found.detail);
      }
    }
  }
}

TEST_CASE("samples that are not finite fail the furnaces") {
  const auto lose = [](std::span<PixelSums>, TraceCounts& counts) { ++counts.nonfinite; };
  CHECK(check_furnaces(lying(Precision::f64, AcceleratorKind::bvh, lose)).status ==
        CheckStatus::failed);
}

TEST_CASE("threads make the same picture, and one wrong picture of a thread is found") {
  CHECK(check_threads(honest, 3).status == CheckStatus::ok);
  std::atomic<int> pieces = 0;
  const TracerMaker once = [&](const Scene& scene, const RenderSettings& settings) {
    return std::make_unique<LyingTracer>(honest(scene, settings),
                                         [&](std::span<PixelSums> sums, TraceCounts&) {
                                           sums[0].sum[0] += pieces++ == 1 ? 1U << 20 : 0;
                                         });
  };
  CHECK(check_threads(once, 2).status == CheckStatus::failed);
}

TEST_CASE("one wrong picture in a hundred is found") {
  std::atomic<int> calls = 0;
  const auto picture = [&] { return std::string(calls++ == 17 ? "other" : "same"); };
  CHECK(check_repetition(picture, 50, 2).status == CheckStatus::failed);
  CHECK(check_repetition(picture, 50, 2).status == CheckStatus::ok);
  calls = -1000;
  const auto broken = [&]() -> std::string {
    return calls++ == -990 ? throw std::runtime_error("out of memory") : "same";
  };
  CHECK_THROWS_AS(check_repetition(broken, 50, 2), RunError);
}

TEST_CASE("the error of a hit is the distance of its point from the surface in ulp(S)") {
  const SphereShape<float> unit{{0, 0, 0}, 1};
  const Ray<float> ray({-2, 0, 0}, {1, 0, 0});
  const auto error = [&](float t) { return backward_error<double, float>(ray, unit, t); };
  CHECK(error(1) == 0);
  CHECK(error(1 + 0x1p-19F) == 8);  // 16 ulp of 1, at S = 2
  CHECK(error(1 - 0x1p-19F) == 8);
  CHECK(std::isnan(error(std::numeric_limits<float>::quiet_NaN())));
}

TEST_CASE("hits keep their bounds, and errors beyond them, or none at all, are failures") {
  const HitErrors worst = worst_hit_errors(20'000);
  CHECK(check_hit_errors(worst).status == CheckStatus::ok);
  CHECK(worst.hits > 40'000);
  CHECK(worst.f32 > 0.1);  // the oracle does look
  CHECK(worst.f64 > 0.1);
  CHECK(worst.mixed > 0);
  const auto status = [](const HitErrors& errors) { return check_hit_errors(errors).status; };
  CHECK(status({8, 2, 8, 1}) == CheckStatus::ok);
  CHECK(status({8.1, 2, 8, 1}) == CheckStatus::failed);
  CHECK(status({8, 2.1, 8, 1}) == CheckStatus::failed);
  CHECK(status({8, 2, 8.1, 1}) == CheckStatus::failed);
  CHECK(status({std::nan(""), 2, 8, 1}) == CheckStatus::failed);
  CHECK(status({0, 0, 0, 0}) == CheckStatus::failed);
}

TEST_CASE("messages arrive over loopback") {
  const CheckResult found = check_messages(seconds(10));
  CHECK_MESSAGE(found.status == CheckStatus::ok, found.detail);
}

TEST_CASE("keys admit only the known client, and a faulty authenticator is found") {
  const TemporaryDirectory first;
  const TemporaryDirectory careless;
  const TemporaryDirectory deaf;
  CHECK(check_keys(seconds(10), first.path()).status == CheckStatus::ok);
  const CheckResult open = check_keys(seconds(10), careless.path(), KeyTrial::accepts_anybody);
  CHECK(open.status == CheckStatus::failed);
  CHECK(open.detail == "the server accepts a client with an unknown key");
  const CheckResult closed =
      check_keys(milliseconds(500), deaf.path(), KeyTrial::refuses_everybody);
  CHECK(closed.status == CheckStatus::failed);
  CHECK(closed.detail == "the server refuses a client with a known key");
}

TEST_CASE("a value is found under its key, the first of several") {
  std::istringstream lines("processor\t: 0\nmodel name\t: A : B \nmodel name: C\nodd line\n");
  CHECK(value_of(lines, "model name") == "A : B");
  std::istringstream none("model\t: 1\n");
  CHECK(value_of(none, "model name").empty());
}

TEST_CASE("little memory is a warning, and unknown memory is no finding") {
  constexpr std::uint64_t total = std::uint64_t{8} << 30;
  CHECK(check_memory(total / 2, total).status == CheckStatus::ok);
  CHECK(check_memory(1, total).status == CheckStatus::warning);
  CHECK(check_memory(0, total).status == CheckStatus::skipped);
  CHECK(check_memory(0, 0).status == CheckStatus::skipped);
}

TEST_CASE("a container's small shared memory is a warning with a remedy") {
  const std::uint64_t needed = window_bytes();
  CHECK(needed > 64 << 20);
  const CheckResult small = check_shared_memory(64 << 20, needed);
  CHECK(small.status == CheckStatus::warning);
  CHECK(small.remedy.find("--shm-size") != std::string::npos);
  CHECK(check_shared_memory(needed, needed).status == CheckStatus::ok);
}

TEST_CASE(
    "pictures and state are read back from a directory, and a missing directory is a failure") {
  const TemporaryDirectory directory;
  CHECK(check_pictures(directory.path()).status == CheckStatus::ok);
  CHECK(check_state(directory.path()).status == CheckStatus::ok);
  const fs::path nowhere = directory.path() / "a" / "b";
  CHECK(run({"pictures", [&] { return check_pictures(nowhere); }}).status == CheckStatus::failed);
  std::ofstream(directory.path() / "file").close();
  CHECK(run({"state", [&] { return check_state(directory.path() / "file"); }}).status ==
        CheckStatus::failed);
  CHECK(check_current_directory(directory.path()).status == CheckStatus::ok);
  CHECK(check_current_directory(nowhere).status == CheckStatus::warning);
}

TEST_CASE("the scratch directory is removed with everything in it") {
  fs::path path;
  {
    std::optional<OwnedPath> scratch;
    CHECK(check_temporary_directory(scratch).status == CheckStatus::ok);
    path = scratch.value().path();
    CHECK(fs::is_empty(path));
    std::ofstream(path / "file") << "text";
  }
  CHECK_FALSE(fs::exists(path));
}

TEST_CASE("a program is the first executable file of its name in PATH") {
  const TemporaryDirectory directory;
  for (const char* name : {"a", "b", "c"}) fs::create_directory(directory.path() / name);
  std::ofstream(directory.path() / "a" / "mpirun") << "not executable";
  const fs::path second = script(directory.path() / "b", "mpirun", "exit 0");
  script(directory.path() / "c", "mpirun", "exit 0");
  const std::string root = directory.path().string();
  CHECK(find_program("mpirun", root + "/a:" + root + "/b:" + root + "/c") == second);
  CHECK_FALSE(find_program("mpirun", root + "/a:" + root));
  CHECK_FALSE(find_program("mpirun", ""));
}

TEST_CASE("output, variables and exit status of a child process are passed on") {
  const TemporaryDirectory directory;
  const fs::path log = directory.path() / "log";
  const auto end_of = [&](const std::string& lines) {
    const fs::path file = script(directory.path(), "child", lines);
    return run_child({file.string(), "an argument"}, {"PARRAY_TRIAL=1=2", "HOME=/elsewhere"}, log,
                     seconds(60));
  };
  CHECK(end_of("echo \"$1 $PARRAY_TRIAL $HOME\"; echo error >&2; cat; exit 3").status == 3);
  std::ifstream text(log);
  std::string line;
  CHECK(std::getline(text, line));
  CHECK(line == "an argument 1=2 /elsewhere");
  CHECK(std::getline(text, line));
  CHECK(line == "error");
  CHECK(end_of("kill -9 $$").status == 128 + 9);
  CHECK_THROWS_AS(run_child({"/nonexistent"}, {}, log, seconds(1)), RunError);
}

TEST_CASE("a child process that does not end is killed with its own children") {
  const TemporaryDirectory directory;
  const std::string file = (directory.path() / "pid").string();
  const fs::path child =
      script(directory.path(), "child",
             "sleep 1000 &\necho $! > " + file + ".new\nmv " + file + ".new " + file + "\nwait");
  Time limit = seconds(1);
  const auto killed_child = [&] {
    return run_child({child.string()}, {}, directory.path() / "log", limit);
  };
  ChildEnd end = killed_child();
  while (!fs::exists(file) && limit < seconds(60)) {  // on a slow machine, it starts slowly
    limit *= 4;
    end = killed_child();
  }
  CHECK(end.timed_out);
  const SteadyClock clock;
  const Time latest = clock.now() + seconds(60);
  while (!gone(file) &&
         clock.now() < latest) {  // the signal is sent, and the process dies when it runs next
    std::this_thread::sleep_for(milliseconds(5));
  }
  CHECK(gone(file));
}

TEST_CASE("the check of mpirun is skipped if it is missing, and otherwise depends on its result") {
  const TemporaryDirectory directory;
  const fs::path& here = directory.path();
  MpiTrial trial;
  trial.parray_mpi = script(here, "parray-mpi", "exit 0");
  trial.directory = here;
  trial.image_sha256 = "0123456789abcdef0123";
  CHECK(check_mpi_trial(trial).status == CheckStatus::skipped);
  CHECK(check_mpi_trial(trial).remedy.find("openmpi-bin") != std::string::npos);

  const auto with = [&](const std::string& lines) {
    trial.mpirun = script(here, "mpirun", lines);
    return check_mpi_trial(trial);
  };
  const auto report = [](const std::string& sha, const std::string& transport, int ranks) {
    std::string list = "{}";
    for (int i = 1; i < ranks; ++i) list += ", {}";
    return "test \"$5\" = " + sha + " || cat > \"$9\" <<END\n{\"image_sha256\": \"" + sha +
           R"(", "mpi": {"transport": ")" + transport + R"(", "ranks": [)" + list + "]}}\nEND";
  };
  CHECK(with(report(trial.image_sha256, "window", 2)).status == CheckStatus::ok);
  CHECK(with(report(trial.image_sha256, "messages", 2)).status == CheckStatus::warning);
  CHECK(with(report(trial.image_sha256, "memory", 1)).status == CheckStatus::failed);
  CHECK(with(report("another", "window", 2)).status == CheckStatus::failed);
  const CheckResult refused = with("echo ----; echo; echo 'no slots left' >&2; exit 5");
  CHECK(refused.status == CheckStatus::failed);
  CHECK(refused.detail.find("status 5: no slots left") != std::string::npos);
  trial.limit = milliseconds(300);
  const CheckResult stuck = with("echo waiting; exec sleep 1000");
  CHECK(stuck.status == CheckStatus::failed);
  CHECK(stuck.detail.find("did not end") != std::string::npos);

  trial.parray_mpi = here / "nowhere";
  CHECK(check_mpi_trial(trial).status == CheckStatus::skipped);
}

TEST_CASE("the checks have names of their own") {
  std::set<std::string> names;
  for (const Check& check : doctor_checks(true)) CHECK(names.insert(check.name).second);
  CHECK(names.size() >= 20);
}

}  // namespace parray
