#include "cli/output/processor.h"

#include <fstream>
#include <sstream>

#include "common/base/printable.h"
#include "common/base/text.h"

namespace parray::output {

std::string value_of(std::istream& lines, const std::string& key) {
  for (std::string line; std::getline(lines, line);) {
    const std::size_t colon = line.find(':');
    if (colon != std::string::npos && trimmed(std::string_view(line).substr(0, colon)) == key) {
      return std::string(trimmed(std::string_view(line).substr(colon + 1)));
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
