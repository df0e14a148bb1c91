#include "cli/output/picture/color_map.h"

#include <algorithm>
#include <array>

#include "cli/output/picture/srgb.h"
#include "common/base/text.h"

namespace parray::picture {
namespace {

/// Every third of the 256 published colours, in hexadecimal sRGB.
constexpr std::array<std::string_view, 5> map_tables{
    // viridis
    "440154450559460a5d470e61471365481769481b6d481f70482374482677472a7a472e7c46327e453581443983"
    "433d844240864144873f47883e4a893d4e8a3b518b3a548c38588c375b8d355e8d34618d32648e31678e306a8e"
    "2e6d8e2d708e2c728e2b758e2a788e297b8e277e8e26818e25838e24868e23898e228c8d218f8d20928c1f948c"
    "1f978b1f9a8a1e9d891fa0881fa28721a58522a88425ab8227ad812ab07f2eb37c32b67a37b8783bbb7540bd72"
    "46c06f4cc26c52c56958c7655ec96265cb5e6ccd5a73d0567ad15181d34d89d54890d74398d83ea0da39a8db34"
    "b0dd2fb8de29c0df25c8e020d0e11cd8e219dfe318e7e419efe51cf6e620fde725",
    // magma
    "00000401010802020d04041406051a0907200c0926100b2d130d34160f3b1a10421e11492211502712582c115f"
    "31116536106b3b0f70400f744510774a10794f127b54137d59157e5d177f621980671b806b1d81701f81752181"
    "7922827e24828326818827818c2981912b81962c809b2e7fa02f7fa5317eaa337dae347bb3367ab83779bd3977"
    "c23b75c73d73cc3f71d0416fd5446dd9466bde4968e24d66e55064e95462ec5860ef5d5ef2625df4675cf66c5c"
    "f7725cf9785dfa7d5efb835ffc8961fc8e64fd9467fd9a6afe9f6dfea571feaa74feb078feb67cfebb81fec185"
    "fec68afecc8ffed194fed799fddc9efde2a3fde7a9fcecaefcf2b4fcf7b9fcfdbf",
    // inferno
    "00000401010802020e04031407051b0a07220d0829110a30150b37190c3e1e0c45230c4c280b532d0b59320a5e"
    "3809623d0965420a68470b6a4c0c6b510e6c550f6d5a116e5f136e64156e69166e6d186e721a6e771c6d7c1d6d"
    "801f6c85216b8a226a8f24699326679827669d2964a22b62a62d60ab2f5eb0315bb43359b93556bd3853c13a50"
    "c63d4dca404ace4347d24644d54a41d94d3ddd513ae05536e35933e65d2fe9612beb6628ee6a24f06f20f2741c"
    "f47918f67e14f78410f8890cf98e09fa9407fb9906fc9f07fca50afcaa0ffcb014fbb61afbbc21fac228f9c72f"
    "f8cd37f7d340f5d949f4df53f3e55df2ea69f1ef75f2f482f4f88ef8fb9afcffa4",
    // plasma
    "0d088716078a1d068e2406912a05932f05963504983a049a3f049c44039e4903a04e02a25302a35801a45c01a6"
    "6100a76600a76a00a86f00a87401a87801a87d03a88104a78606a68a09a58e0ca4920fa39613a19a169f9e199d"
    "a21d9aa62098aa2395ad2793b12a90b42e8db7318abb3488be3885c13b82c43e7fc7427cca457acc4977cf4c74"
    "d24f71d5536fd7566cda5a6adc5d67de6164e16462e3685fe56b5de76f5ae97257eb7655ed7a52ef7e50f1814d"
    "f3854bf48948f68d45f79143f89540f99a3efa9e3bfba238fca636fdab33fdaf31fdb42ffeb82cfebd2afdc229"
    "fdc627fdcb26fcd025fbd524fada24f8df25f7e425f5e926f3ee27f1f426f0f921",
    // cividis
    "00224e00255300275800295d002b62002d68002f6d0031700533710f35701637701c396f213b6e263d6e2a3f6d"
    "2e416d32436d35456c39486c3c4a6c3f4c6c424e6c45506c48526c4b546c4e566c51586d545a6d565c6d595e6e"
    "5c616e5e636f61656f646770666970696b716c6d726e6f737172747374757676767878777b7a787e7c78807f78"
    "8381798683798985788c88788f8a78928c78948e779791779a93769d9576a09875a39a74a69c74a99f73aca172"
    "afa471b3a670b6a96fb9ab6dbcae6cbfb06bc2b369c5b568c8b866ccba64cfbd62d2c060d5c25ed9c55cdcc859"
    "dfca57e2cd54e6d051e9d34eedd54af0d846f3db42f7de3efbe138fee434fee838",
};
constexpr std::size_t color_digits = 6;  ///< digits per colour

double srgb_component(std::string_view two_digits) {
  const auto value = [](char c) { return c <= '9' ? c - '0' : c - 'a' + 10; };
  return (16 * value(two_digits[0]) + value(two_digits[1])) / 255.0;
}

/// Interpolates the encoded values, as other programs do with such tables.
Vec3d from_table(std::string_view table, double share) {
  const std::size_t last = table.size() / color_digits - 1;
  const double place = share * static_cast<double>(last);
  const std::size_t before = std::min(static_cast<std::size_t>(place), last - 1);
  const double t = place - static_cast<double>(before);
  const auto component = [&](std::size_t i) {
    const double low = srgb_component(table.substr(before * color_digits + 2 * i, 2));
    const double high = srgb_component(table.substr((before + 1) * color_digits + 2 * i, 2));
    return srgb_decode((1 - t) * low + t * high);
  };
  return {component(0), component(1), component(2)};
}

/// Oklab: lightness from 0 to 1, a from green to red, b from blue to yellow. Source: Ottosson, "A
/// perceptual color space for image processing", 2020.
struct Oklab {
  double lightness;
  double a;
  double b;
};

Vec3d linear_rgb(const Oklab& color) {
  const auto cubed = [](double v) { return v * v * v; };
  const double l = cubed(color.lightness + 0.3963377774 * color.a + 0.2158037573 * color.b);
  const double m = cubed(color.lightness - 0.1055613458 * color.a - 0.0638541728 * color.b);
  const double s = cubed(color.lightness - 0.0894841775 * color.a - 1.2914855480 * color.b);
  return {4.0767416621 * l - 3.3077115913 * m + 0.2309699292 * s,
          -1.2684380046 * l + 2.6097574011 * m - 0.3413193965 * s,
          -0.0041960863 * l - 0.7034186147 * m + 1.7076147010 * s};
}

Oklab between(const Oklab& from, const Oklab& to, double share) {
  const auto mix = [share](double x, double y) { return x + share * (y - x); };
  return {mix(from.lightness, to.lightness), mix(from.a, to.a), mix(from.b, to.b)};
}

Vec3d blue_to_red(double share) {
  constexpr Oklab middle{0.96, 0, 0};
  constexpr Oklab blue{0.42, -0.0312, -0.1467};
  constexpr Oklab red{0.42, 0.1450, 0.0676};
  return linear_rgb(share < 0.5 ? between(blue, middle, 2 * share)
                                : between(middle, red, 2 * share - 1));
}

Vec3d dark_to_light(double share) {
  constexpr Oklab dark{0.25, 0, 0};
  constexpr Oklab light{0.98, 0, 0};
  return linear_rgb(between(dark, light, share));
}

/// Returns the linear RGB of CIE L*a*b* under D65, by the inverse of its definition and the matrix
/// of IEC 61966-2-1.
Vec3d linear_rgb(double lightness, double a, double b) {
  const auto cubed = [](double f) {
    constexpr double bend = 6.0 / 29;
    return f > bend ? f * f * f : 3 * bend * bend * (f - 4.0 / 29);
  };
  const double middle = (lightness + 16) / 116;
  const double x = 0.95047 * cubed(middle + a / 500);
  const double y = cubed(middle);
  const double z = 1.08883 * cubed(middle - b / 200);
  return {3.2406 * x - 1.5372 * y - 0.4986 * z, -0.9689 * x + 1.8758 * y + 0.0415 * z,
          0.0557 * x - 0.2040 * y + 1.0570 * z};
}

Vec3d violet_to_yellow(double share) {
  constexpr std::array<std::array<double, 2>, 4> points = {
      {{41, -52}, {-16, -48}, {-48, 25}, {-18, 70}}};
  const double t = share;
  const double s = 1 - t;
  const std::array<double, 4> weights = {s * s * s, 3 * s * s * t, 3 * s * t * t, t * t * t};
  double a = 0;
  double b = 0;
  for (std::size_t i = 0; i < points.size(); ++i) {
    a += weights[i] * points[i][0];
    b += weights[i] * points[i][1];
  }
  return linear_rgb(16 + 74 * t, a, b);
}

}  // namespace

std::optional<ColorMap> color_map_named(std::string_view name) {
  const auto place = place_in(color_map_words, name);
  return place ? std::optional(static_cast<ColorMap>(*place)) : std::nullopt;
}

std::string_view name_of(ColorMap map) { return color_map_words[static_cast<std::size_t>(map)]; }

bool is_diverging(ColorMap map) { return map == ColorMap::blue_red; }

Vec3d color_at(ColorMap map, double share) {
  switch (map) {
    case ColorMap::blue_red: return blue_to_red(share);
    case ColorMap::grey: return dark_to_light(share);
    case ColorMap::violet_yellow: return violet_to_yellow(share);
    default: return from_table(map_tables[static_cast<std::size_t>(map)], share);
  }
}

Vec3d color_of_unknown(ColorMap map) {
  return map == ColorMap::grey ? Vec3d{0.6038, 0.1912, 0.3864} : Vec3d{0.5, 0.5, 0.5};
}

}  // namespace parray::picture
