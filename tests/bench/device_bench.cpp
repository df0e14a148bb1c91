// Checks the bits of device code on a GPU, and measures its speed: tests/bench/device.
#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <iostream>
#include <iterator>
#include <sstream>
#include <stdexcept>
#include <string>
#include <vector>

#include "common/base/error.h"
#include "common/process/command_line.h"
#include "common/process/run_main.h"
#include "tests/bench/bench.h"
#include "tests/bench/device_checks.h"
#include "tests/bench/device_report.h"
#include "tests/bench/device_speed.h"

namespace {

using namespace parray;
using namespace parray::bench;

/// The exit status if something that the bench needs is missing.
constexpr int missing_status = 77;
const char* const program_name = "bench_device";

/// Something that the bench needs is missing. what() is one line.
class Missing : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

struct Arguments {
  std::string library;
  int device = 0;
  std::string code;       ///< folder of kernels.ptx and probe.ptx
  std::string scenes;     ///< folder of the shipped scenes
  std::string generated;  ///< folder of one-weekend-N.json
  std::string output;
  bool quick = false;
  std::vector<std::string> parts;
  std::string picture, spheres, precisions, caps, blocks, speed_picture;
  double operations = 0;
  double time_limit = 0;
  double launch_ms = 30;
  double cpu_seconds = 0.3;
  int rounds = 0;

  [[nodiscard]] bool wants(const std::string& part) const {
    return parts.empty() || std::find(parts.begin(), parts.end(), part) != parts.end();
  }
};

std::string text_of_file(const std::filesystem::path& path) {
  std::ifstream file(path, std::ios::binary);
  if (!file) {
    throw Missing("no device code: " + path.string() +
                  " is missing. The build makes it if clang++ is installed");
  }
  return {std::istreambuf_iterator<char>(file), {}};
}

/// Reads numbers between `separator`s.
std::vector<int> numbers_in(const std::string& text, char separator) {
  std::vector<int> numbers;
  std::istringstream words(text);
  for (std::string word; std::getline(words, word, separator);) {
    try {
      numbers.push_back(word == "none" ? 0 : std::stoi(word));
    } catch (const std::exception&) {
      throw InputError("\"" + word + "\" in \"" + text + "\" is not a number");
    }
  }
  return numbers;
}

/// Reads the form WIDTHxHEIGHTxSAMPLES, with as many numbers as `count`.
std::vector<std::uint32_t> size_of(const std::string& text, std::size_t count) {
  std::vector<std::uint32_t> size;
  for (const int number : numbers_in(text, 'x')) size.push_back(static_cast<std::uint32_t>(number));
  const bool positive = std::find(size.begin(), size.end(), 0U) == size.end();
  if (size.size() != count || !positive) {
    throw InputError("\"" + text + "\" is not a size of " + std::to_string(count) +
                     " positive numbers such as 60x40x8");
  }
  return size;
}

const std::string& or_else(const std::string& given, const std::string& other) {
  return given.empty() ? other : given;
}

SpeedOptions speed_options(const Arguments& a) {
  SpeedOptions options;
  for (const int count : numbers_in(
           or_else(a.spheres, a.quick ? "486,8,100000" : "486,8,20,4097,100000,1000000"), ',')) {
    options.spheres.push_back(static_cast<std::uint32_t>(count));
  }
  std::istringstream names(or_else(a.precisions, "f32,mixed,f64"));
  for (std::string name; std::getline(names, name, ',');) {
    options.precisions.push_back(precision_from(name));
  }
  options.caps = numbers_in(or_else(a.caps, a.quick ? "none,96" : "none,64,80,96,128,168"), ',');
  for (const int block : numbers_in(or_else(a.blocks, a.quick ? "128" : "64,128,256"), ',')) {
    options.blocks.push_back(static_cast<std::uint32_t>(block));
  }
  const auto size = size_of(or_else(a.speed_picture, "960x640"), 2);
  options.width = size[0];
  options.height = size[1];
  options.launch_seconds = a.launch_ms / 1e3;
  options.cpu_seconds = a.cpu_seconds;
  options.rounds = a.rounds > 0 ? static_cast<std::size_t>(a.rounds) : a.quick ? 3 : 5;
  options.cpu_rounds = a.quick ? 1 : 3;
  options.generated = a.generated;
  return options;
}

void print_device(const test::DeviceFacts& facts) {
  std::printf(
      "%s, compute capability %d.%d, %d multiprocessors, %.1f GiB%s, %.0f MHz, driver for "
      "CUDA %s\n",
      facts.name.c_str(), facts.capability_major, facts.capability_minor, facts.multiprocessors,
      static_cast<double>(facts.memory) / 0x1p30, facts.ecc ? " with ECC" : "", facts.clock_mhz,
      facts.driver.c_str());
}

int cap_of(const Json& cell) {
  return numbers_in(cell["most_registers"].get<std::string>(), ',').front();
}

/// One run of the bench. After each part it writes what there is.
class Run {
 public:
  Run(const Arguments& arguments, const test::CudaDevice& device, std::string kernels)
      : arguments_(arguments),
        time_(arguments.time_limit > 0 ? arguments.time_limit
              : arguments.quick        ? 50
                                       : 440),
        device_(device),
        modules_(device, std::move(kernels)) {
    report_["device"] = facts_of(device);
    report_["wrong"] = Json::array();
  }

  void check() {
    const test::CudaLauncher launcher(device_, modules_.with(0));
    if (arguments_.wants("fingerprint")) keep("fingerprint", check_fingerprint(launcher, verdict_));
    if (arguments_.wants("pictures")) {
      const auto size = size_of(or_else(arguments_.picture, "60x40x8"), 3);
      keep("pictures",
           check_pictures(arguments_.scenes, {size[0], size[1], size[2]}, launcher, verdict_));
    }
  }

  void check_arithmetic(const std::string& probes) {
    if (!arguments_.wants("operations")) return;
    const double count = arguments_.operations > 0 ? arguments_.operations
                         : arguments_.quick        ? 1e8
                                                   : 1e9;
    const test::CudaModule module(device_.driver(), probes);
    keep("operations",
         check_operations(static_cast<std::uint64_t>(count), device_, module, verdict_));
  }

  void measure() {
    const SpeedOptions options = speed_options(arguments_);
    if (arguments_.wants("speed")) {
      measure_speed(options, time_, device_, modules_, verdict_,
                    [this](const Json& figures) { keep("speed", figures); });
      const std::string goal = goal_line(report_);
      if (!goal.empty()) std::printf("%s\n", goal.c_str());
    }
    if (arguments_.wants("launches") && time_.allows(5)) {
      const Json row = goal_row(report_);
      const int cap = row.is_null() ? options.caps.front() : cap_of(row["best"]);
      const std::uint32_t block =
          row.is_null() ? options.blocks.front() : row["best"]["block"].get<std::uint32_t>();
      keep("launches", measure_launches(options, cap, block, device_, modules_));
    }
  }

  [[nodiscard]] int finish() {
    std::printf("%zu wrong, %.1f s\n", verdict_.found().size(), time_.used());
    return verdict_.found().empty() ? 0 : 1;
  }

 private:
  void keep(const std::string& part, Json figures) {
    report_[part] = std::move(figures);
    report_["wrong"] = verdict_.found();
    report_["seconds"] = time_.used();
    static_cast<void>(std::fflush(stdout));
    if (!arguments_.output.empty()) write_report(report_, arguments_.output);
  }

  const Arguments& arguments_;
  const TimeLimit time_;
  const test::CudaDevice& device_;
  ModulesByCap modules_;
  Verdict verdict_;
  Json report_;
};

int run(const Arguments& arguments) {
  try {
    const std::filesystem::path code = arguments.code;
    std::string kernels = text_of_file(code / "kernels.ptx");
    const std::string probes = text_of_file(code / "probe.ptx");
    const test::CudaDriver driver(arguments.library);
    const test::CudaDevice device(driver, arguments.device);
    print_device(device.facts());
    Run run(arguments, device, std::move(kernels));
    run.check();
    run.check_arithmetic(probes);
    run.measure();
    return run.finish();
  } catch (const Missing& missing) {
    return process::fail(program_name, missing_status, missing.what());
  } catch (const test::NoDevice& missing) {
    return process::fail(program_name, missing_status, missing.what());
  }
}

void declare_sizes(CommandLine& line, Arguments& a) {
  line.option("--picture", a.picture, "Width, height and samples of the pictures: 60x40x8");
  line.number("--operations", a.operations, 0, 1e13,
              "Random divisions and roots; 0: 1e9, with --quick 1e8");
  line.option("--spheres", a.spheres, "Sizes of the scenes that are measured: 486,8,...");
  line.option("--precisions", a.precisions, "Precisions that are measured: f32,mixed,f64");
  line.option("--caps", a.caps, "Most registers of a thread: none,64,...");
  line.option("--blocks", a.blocks, "Threads of a block: 64,128,...");
  line.option("--speed-picture", a.speed_picture, "Width and height of measured pictures: 960x640");
  line.number("--launch-ms", a.launch_ms, 0.001, 1e4, "About the time of a measured launch")
      .show_default();
  line.number("--rounds", a.rounds, 0, 1000,
              "Measured launches of each cell; 0: 5, with --quick 3");
  line.number("--cpu-seconds", a.cpu_seconds, 0, 60, "Time of each measurement of the CPU")
      .show_default();
  line.number("--time-limit", a.time_limit, 0, 1e6,
              "Measures no further scene after so many seconds; 0: 440, with --quick 50");
}

}  // namespace

int main(int argc, char** argv) {
  Arguments a;
  const Program program = {
      program_name,
      "Checks device code on a GPU bit by bit, and measures it. Status 77: nothing to test with",
      PARRAY_VERSION};
  warn_of_assertions();
  return run_main(program, argc, argv, [&](CommandLine& line) {
    line.option("--code", a.code, "Folder of kernels.ptx and probe.ptx").required();
    line.option("--scenes", a.scenes, "Folder of the shipped scenes").required();
    line.option("--generated", a.generated, "Folder of one-weekend-N.json").required();
    line.option("--driver", a.library,
                "CUDA's driver library (default: libcuda.so.1 of the system)");
    line.number("--device", a.device, 0, 1000, "Number of the device").show_default();
    line.option("-o,--output", a.output, "Folder for device.md and device.json");
    line.flag("--quick", a.quick, "Less of everything: below a minute");
    line.option("--only", a.parts,
                "Only this part; several times: fingerprint, pictures, operations, speed, launches")
        .one_value_each()
        .one_of({"fingerprint", "pictures", "operations", "speed", "launches"});
    declare_sizes(line, a);
    return [&] { return run(a); };
  });
}
