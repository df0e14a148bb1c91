// Checks that the tracer's source contains no comparison with a small constant: no t_min, no
// offset, no scene size.
#include <doctest/doctest.h>

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <regex>
#include <sstream>
#include <string>
#include <vector>

#include "tests/support/extremes.h"
#include "tests/support/rooms.h"

namespace parray::test {
namespace {

namespace fs = std::filesystem;

/// Returns the lines of a text without comments.
std::vector<std::string> code_lines(const std::string& text) {
  std::vector<std::string> lines;
  std::istringstream in(text);
  for (std::string line; std::getline(in, line);) {
    lines.push_back(line.substr(0, line.find("//")));
  }
  return lines;
}

/// Returns the literals of a line that are above 0 and at most 1/1000.
std::vector<std::string> small_literals(const std::string& line) {
  static const std::regex literal(
      R"((^|[^\w.])((0[xX][\da-fA-F'.]+[pP][+-]?\d+|\d[\d']*\.?\d*[eE][+-]?\d+|\d+\.\d*|\.\d+)[fFlL]?))");
  std::vector<std::string> found;
  for (std::sregex_iterator it(line.begin(), line.end(), literal), end; it != end; ++it) {
    std::string digits = (*it)[2];
    digits.erase(std::remove(digits.begin(), digits.end(), '\''), digits.end());
    const double value = std::strtod(digits.c_str(), nullptr);
    if (value > 0 && value <= 1e-3) found.push_back((*it)[2]);
  }
  return found;
}

/// Small numbers that are not epsilons: the spacing of random numbers and of floating-point
/// numbers.
bool is_allowed(const std::string& file, const std::string& line) {
  return (file == "random.h" && line.find("* Real(0x1p-24)") != std::string::npos) ||
         (file == "real.h" && line.find(" unit_roundoff = ") != std::string::npos);
}

std::vector<std::string> epsilons_of(const std::string& file, const std::string& text) {
  std::vector<std::string> found;
  for (const std::string& line : code_lines(text)) {
    const bool named = std::regex_search(
        line, std::regex(R"(\b(epsilon|eps|t_?min|[a-z_]*_offset|tolerance|bias)\b)"));
    if ((named || !small_literals(line).empty()) && !is_allowed(file, line)) {
      found.push_back(file);
      found.back() += ": " + line;
    }
  }
  return found;
}

}  // namespace

TEST_CASE("the source has no epsilon") {
  double files = 0;
  double epsilons = 0;
  for (const std::string folder : {"common/trace", "common/math"}) {
    for (const auto& entry :
         fs::recursive_directory_iterator(fs::path(PARRAY_SOURCE_DIR) / folder)) {
      const std::string extension = entry.path().extension().string();
      if (!entry.is_regular_file() || (extension != ".h" && extension != ".cpp")) continue;
      std::ifstream in(entry.path());
      std::ostringstream text;
      text << in.rdbuf();
      ++files;
      for (const std::string& line : epsilons_of(entry.path().filename().string(), text.str())) {
        MESSAGE(line);
        ++epsilons;
      }
    }
  }
  CHECK(files > 30);
  within(0, "epsilons in the source of the tracer", epsilons, 0);
}

TEST_CASE("the search for epsilons finds them, however they are written") {
  for (const std::string line :
       {"if (t > 1e-4)", "t > 0.001F - x", "const Real t_min = x;", "return p + 0x1p-20 * n;",
        "x < .0005", "return std::numeric_limits<Real>::epsilon();", "float f = 1'0e-6f;"}) {
    CAPTURE(line);
    CHECK(epsilons_of("sphere.h", line).size() == 1);
  }
  for (const std::string line :
       {"x * 0.5", "y = 1e3; // 1e-3", "Real(32) * unit_roundoff", "1e15"}) {
    CAPTURE(line);
    CHECK(epsilons_of("sphere.h", line).empty());
  }
}

}  // namespace parray::test
