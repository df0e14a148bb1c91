#include <doctest/doctest.h>

#include <fstream>
#include <regex>
#include <string>
#include <string_view>
#include <vector>

/// The PTX of the kernels, as a driver will read it. A driver may fuse a product and a sum without
/// a mark of rounding. So every operation must have one.
namespace parray::test {
namespace {

/// Returns the instructions of a text: the first words of its lines, without predicates.
std::vector<std::string> instructions_of(std::istream& text) {
  static const std::regex instruction(R"(^\s+(?:@!?%\w+\s+)?([a-z][\w.:]*)[\s;].*)");
  std::vector<std::string> found;
  std::smatch match;
  for (std::string line; std::getline(text, line);) {
    if (std::regex_match(line, match, instruction)) found.push_back(match[1]);
  }
  return found;
}

bool has_part(const std::string& instruction, std::string_view part) {
  return ("." + instruction + ".").find("." + std::string(part) + ".") != std::string::npos;
}

/// Returns what is wrong with an instruction; empty: nothing.
std::string problem_of(const std::string& instruction) {
  const std::string name = instruction.substr(0, instruction.find('.'));
  const bool real = has_part(instruction, "f32") || has_part(instruction, "f64");
  if (name == "fma" || (name == "mad" && real)) return instruction + " fuses";
  for (const std::string_view part : {"approx", "ftz", "full", "sat"}) {
    if (has_part(instruction, part)) return instruction + " is not IEEE 754";
  }
  for (const std::string_view rounded : {"add", "sub", "mul", "div", "rcp", "sqrt"}) {
    if (name == rounded && real && !has_part(instruction, "rn")) {
      return instruction + " has no rounding";
    }
  }
  for (const std::string_view never : {"sin", "cos", "lg2", "ex2", "tanh", "rsqrt"}) {
    if (name == never) return instruction + " is not exact";
  }
  return "";
}

std::vector<std::string> problems_in(const std::string& file) {
  std::ifstream in(file);
  std::vector<std::string> problems;
  for (const std::string& instruction : instructions_of(in)) {
    if (std::string problem = problem_of(instruction); !problem.empty()) {
      problems.push_back(std::move(problem));
    }
  }
  return problems;
}

}  // namespace

TEST_CASE("the check of PTX refuses what a driver may round differently") {
  for (const std::string bad :
       {"fma.rn.f32", "fma.rn.f64", "mad.f32", "add.f32", "sub.f64", "mul.f32", "mul.ftz.f32",
        "mul.rn.ftz.f32", "div.approx.f32", "div.full.f32", "div.f64", "rcp.approx.ftz.f32",
        "sqrt.approx.f32", "sqrt.f64", "rsqrt.approx.f64", "sin.approx.f32", "add.rn.sat.f32"}) {
    CAPTURE(bad);
    CHECK(problem_of(bad) != "");
  }
  for (const std::string good :
       {"add.rn.f32", "sub.rn.f64", "mul.rn.f32", "div.rn.f32", "rcp.rn.f64", "sqrt.rn.f32",
        "add.s32", "mad.lo.s32", "mul.wide.u32", "cvt.rn.f32.u32", "neg.f32", "setp.gt.f32"}) {
    CAPTURE(good);
    CHECK(problem_of(good) == "");
  }
}

TEST_CASE("the kernels' PTX rounds every operation by itself") {
  const std::string file = PARRAY_DEVICE_DIR "/kernels.ptx";
  std::ifstream in(file);
  if (!in) {
    MESSAGE("skipped: the build has no " << file << " (it needs clang)");
    return;
  }
  const std::vector<std::string> instructions = instructions_of(in);
  const auto count = [&](std::string_view name) {
    return std::count(instructions.begin(), instructions.end(), name);
  };
  CHECK(count("add.rn.f32") > 100);
  CHECK(count("mul.rn.f64") > 100);
  CHECK(count("sqrt.rn.f32") > 10);
  CHECK(count("sqrt.rn.f64") > 10);
  for (const std::string& problem : problems_in(file)) CHECK_MESSAGE(false, problem);
  const std::string fused = PARRAY_DEVICE_DIR "/fused.ptx";
  CHECK(problems_in(fused).size() > 100);
}

TEST_CASE("the PTX of random operations rounds every operation by itself") {
  const std::string file = PARRAY_DEVICE_DIR "/probe.ptx";
  if (!std::ifstream(file)) {
    MESSAGE("skipped: the build has no " << file << " (it needs clang)");
    return;
  }
  for (const std::string& problem : problems_in(file)) CHECK_MESSAGE(false, problem);
  const auto fused = problems_in(PARRAY_DEVICE_DIR "/fused_probe.ptx");
  CHECK(std::count_if(fused.begin(), fused.end(), [](const std::string& problem) {
          return problem.ends_with("fuses");
        }) == 2);  // in f32 and in f64
}

}  // namespace parray::test
