#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "tests/support/particle_files.h"
#include "tests/support/rooms.h"

/// GSD files, written according to the description of their format.
namespace parray::test {

/// A chunk of a frame. The type is the number that GSD gives it: 3 uint32, 4 uint64, 5 int8,
/// 7 int32, 9 float, 10 double.
struct GsdPart {
  std::string name;
  std::uint8_t type = 9;
  std::uint64_t rows = 0;
  std::uint32_t columns = 1;
  std::string bytes;
};

template <typename T>
GsdPart gsd_part(const std::string& name, std::uint8_t type, std::uint32_t columns,
                 const std::vector<T>& values) {
  GsdPart part{name, type, values.size() / columns, columns, {}};
  for (const T value : values) part.bytes += bytes_of(value);
  return part;
}

inline GsdPart gsd_floats(const std::string& name, std::uint32_t columns,
                          const std::vector<float>& values) {
  return gsd_part(name, 9, columns, values);
}

inline GsdPart gsd_count(std::uint32_t particles) {
  return gsd_part<std::uint32_t>("particles/N", 3, 1, {particles});
}

using GsdFrameParts = std::vector<GsdPart>;

/// Writes frames with a version of the file layer. An empty frame repeats the first one.
inline std::string gsd_file(const std::vector<GsdFrameParts>& frames, std::uint32_t version = 2,
                            const std::string& schema = "hoomd") {
  constexpr std::size_t header_bytes = 256;
  constexpr std::uint64_t name_bytes = 64;
  std::map<std::string, std::uint16_t> ids;
  std::string names;
  std::string data;
  std::string index;
  for (std::size_t frame = 0; frame < frames.size(); ++frame) {
    for (const GsdPart& part : frames[frame]) {
      const auto [id, fresh] = ids.try_emplace(part.name, static_cast<std::uint16_t>(ids.size()));
      if (fresh) names += part.name + std::string(version < 2 ? 64 - part.name.size() : 1, '\0');
      index += bytes_of(static_cast<std::uint64_t>(frame)) + bytes_of(part.rows) +
               bytes_of(static_cast<std::uint64_t>(header_bytes + data.size())) +
               bytes_of(part.columns) + bytes_of(id->second) + static_cast<char>(part.type) + '\0';
      data += part.bytes;
    }
  }
  index += std::string(3 * 32, '\0');  // allocated entries that are not used
  names.resize((names.size() / name_bytes + 1) * name_bytes);
  const auto fixed = [](std::string text) {
    text.resize(name_bytes);
    return text;
  };
  const std::uint64_t names_at = header_bytes + data.size();
  std::string header =
      bytes_of(std::uint64_t{0x65DF65DF65DF65DF}) + bytes_of(names_at + names.size()) +
      bytes_of(static_cast<std::uint64_t>(index.size() / 32)) + bytes_of(names_at) +
      bytes_of(names.size() / name_bytes) + bytes_of(std::uint32_t{0x10004}) +
      bytes_of(version << 16U) + fixed("test") + fixed(schema);
  header.resize(header_bytes);
  return header + data + names + index;
}

/// Returns two particles of the types A and long, in three frames. The second frame repeats the
/// first one. The third has other positions, box and step.
inline std::string sample_gsd(std::uint32_t version = 2) {
  const GsdFrameParts first{gsd_part<std::uint64_t>("configuration/step", 4, 1, {10}),
                            gsd_floats("configuration/box", 6, {4, 6, 8, 0.5F, 0.25F, -0.5F}),
                            gsd_count(2),
                            {"particles/types", 5, 2, 5, std::string("A\0\0\0\0long\0", 10)},
                            gsd_part<std::uint32_t>("particles/typeid", 3, 1, {1, 0}),
                            gsd_floats("particles/diameter", 1, {1, 0.5F}),
                            gsd_floats("particles/mass", 1, {2, 3}),
                            gsd_floats("particles/position", 3, {0, 0.5F, 1, -1, -2, -3}),
                            gsd_floats("particles/velocity", 3, {1, 2, 3, 4, 5, 6}),
                            gsd_part<std::int32_t>("particles/image", 7, 3, {0, 1, 0, 0, 0, -1}),
                            gsd_floats("particles/orientation", 4, {1, 0, 0, 0, 0, 1, 0, 0}),
                            gsd_part<double>("log/particles/pair/Energies", 10, 1, {-1.5, -2.5})};
  const GsdFrameParts third{gsd_part<std::uint64_t>("configuration/step", 4, 1, {30}),
                            gsd_floats("configuration/box", 6, {5, 5, 5, 0, 0, 0}),
                            gsd_floats("particles/position", 3, {1, 1, 1, 2, 2, 2})};
  return gsd_file({first, {}, third}, version);
}

}  // namespace parray::test
