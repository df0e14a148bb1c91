#include "cli/output/processor.h"

#include <fstream>
#include <sstream>

#include "common/base/printable.h"

namespace parray::output {
namespace {

std::string trimmed(const std::string& text) {
  const std::size_t begin = text.find_first_not_of(" \t");
  const std::size_t end = text.find_last_not_of(" \t");
  return begin == std::string::npos ? "" : text.substr(begin, end - begin + 1);
}

}  // namespace

std::string value_of(std::istream& lines, const std::string& key) {
  for (std::string line; std::getline(lines, line);) {
    const std::size_t colon = line.find(':');
    if (colon != std::string::npos && trimmed(line.substr(0, colon)) == key) {
      return trimmed(line.substr(colon + 1));
    }
  }
  return "";
}

std::string processor_model() {
  std::ifstream file("/proc/cpuinfo");
  const std::string model = printable(value_of(file, "model name"));
  return model.empty() ? "unknown processor" : model;
}

std::string short_processor(const std::string& model) {
  std::istringstream words(model.substr(0, model.find(" @")));
  std::string text;
  for (std::string word; words >> word;) {
    for (const char* mark : {"(R)", "(TM)", "(r)", "(tm)"}) {
      const std::size_t at = word.find(mark);
      if (at != std::string::npos) word.erase(at, std::string(mark).size());
    }
    if (word.empty() || word == "CPU" || word == "Processor" || word.ends_with("-Core")) continue;
    text += (text.empty() ? "" : " ") + word;
  }
  return text.empty() ? model : text;
}

}  // namespace parray::output
