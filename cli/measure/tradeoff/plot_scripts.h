#pragma once

#include <array>
#include <string_view>

#include "common/rooms.h"

namespace parray::tradeoff {

/// A file plots/NAME.gp of the source. CMake writes plot_scripts.cpp, which contains their texts.
struct PlotScript {
  std::string_view name;
  std::string_view text;
};
extern const std::array<PlotScript, 7> plot_scripts;

}  // namespace parray::tradeoff
