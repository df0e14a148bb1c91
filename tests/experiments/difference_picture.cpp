// The verification picture of the seed program's report (its equation 1): V = sum of |R - F| over
// pictures F of other programs, R being the first; drawn as white less V.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <iostream>

#include "common/base/error.h"
#include "common/image/image_file.h"

namespace {

using namespace parray;

/// Adds |reference - other| to `sum`. A NaN in one of them is a difference; in both it is none.
void add_difference(const Image& reference, const Image& other, Image& sum) {
  for (std::size_t i = 0; i < sum.rgb.size(); ++i) {
    const float a = reference.rgb[i];
    const float b = other.rgb[i];
    const bool equal = a == b || (std::isnan(a) && std::isnan(b));
    const float difference = std::abs(a - b);
    sum.rgb[i] += equal ? 0 : std::isnan(difference) ? 1 : difference;
  }
}

int draw(int argc, char** argv) {
  if (argc < 4) {
    std::puts("usage: difference_picture V.png REFERENCE IMAGE...");
    return 2;
  }
  const Image reference = read_image(argv[2]).image;
  Image sum{reference.width, reference.height, std::vector<float>(reference.rgb.size())};
  for (int i = 3; i < argc; ++i) {
    const Image other = read_image(argv[i]).image;
    if (other.width != reference.width || other.height != reference.height) {
      throw InputError(std::string(argv[i]) + ": not the size of " + argv[2]);
    }
    add_difference(reference, other, sum);
  }
  const float largest = *std::max_element(sum.rgb.begin(), sum.rgb.end());
  for (float& value : sum.rgb) {
    value = std::max(0.0F, 1 - value);
  }
  write_image(argv[1], sum, {});
  std::printf("%d pictures, largest difference %g: %s\n", argc - 3, static_cast<double>(largest),
              largest > 0 ? "NOT all white" : "all white");
  return largest > 0 ? 1 : 0;
}

}  // namespace

int main(int argc, char** argv) {
  try {
    return draw(argc, argv);
  } catch (const InputError& error) {
    std::cerr << "difference_picture: " << error.what() << "\n";
    return 2;
  } catch (const std::exception& error) {
    std::cerr << "difference_picture: " << error.what() << "\n";
    return 1;
  }
}
