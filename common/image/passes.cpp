#include "common/image/passes.h"

#include <algorithm>
#include <array>

namespace parray {
std::string_view name_of(StopReason reason) {
  constexpr std::array<std::string_view, 5> names{"samples", "error", "half_width", "time",
                                                  "passes"};
  return names[static_cast<std::size_t>(reason)];
}
PassSize next_pass_size(const PictureState& s, const RenderSettings& settings, std::uint32_t pass,
                        std::uint64_t affordable) {
  const std::uint64_t pixels = s.pixels.size();
  std::uint64_t have = 0;
  for (auto c : s.counts) have += c;
  if (!settings.passes.empty())
    return pass < settings.passes.size() ? PassSize{settings.passes[pass], {}}
                                         : PassSize{0, StopReason::passes};
  const std::uint64_t all = pixels * settings.samples_per_pixel;
  if (have >= all) return {0, StopReason::samples};
  if (affordable < pixels) return {0, StopReason::time};
  return {std::min({have == 0 ? pixels * 16 : have, all - have, affordable / 2}), {}};
}
std::vector<std::uint32_t> counts_after_pass(const PictureState& s, const RenderSettings& settings,
                                             std::uint32_t pass, std::uint64_t samples) {
  std::vector<std::uint32_t> counts(s.counts.begin(), s.counts.end());
  const auto each = static_cast<std::uint32_t>(std::max<std::uint64_t>(samples / counts.size(), 1));
  for (std::size_t i = 0; i < counts.size(); ++i)
    counts[i] += settings.adaptive && pass > 0 ? each * static_cast<std::uint32_t>(i % 3) : each;
  return counts;
}
}  // namespace parray
