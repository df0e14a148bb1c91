#include "cli/input/scene_file/duplicates.h"

#include <algorithm>
#include <bit>
#include <cstdint>
#include <limits>
#include <span>
#include <utility>
#include <vector>

#include "common/base/bands.h"

namespace parray::input {
namespace {

/// Returns a hash of the four numbers by the steps of splitmix64.
/// Source: Steele, Lea, Flood, "Fast splittable pseudorandom number generators", OOPSLA 2014.
std::uint64_t hash_of(const Sphere& sphere) {
  std::uint64_t hash = 0;
  for (const double x : {sphere.center.x, sphere.center.y, sphere.center.z, sphere.radius}) {
    hash += 0x9E3779B97F4A7C15 + std::bit_cast<std::uint64_t>(x + 0.0);  // -0 + 0 is 0
    hash = (hash ^ (hash >> 30)) * 0xBF58476D1CE4E5B9;
    hash = (hash ^ (hash >> 27)) * 0x94D049BB133111EB;
    hash ^= hash >> 31;
  }
  return hash;
}

/// The place of a sphere with a tag. Comparing tags avoids access to most spheres.
struct Entry {
  std::uint32_t tag;  ///< part of the sphere's hash
  std::uint32_t place;
};

struct Repeat {
  std::uint32_t place;
  std::uint32_t of;
};

/// The spheres, divided into parts by the first bits of their tags. Equal spheres are in the same
/// part. The hash table of a part fits into the cache. Within a part, spheres keep their order.
class Parts {
 public:
  Parts(const std::vector<Sphere>& spheres, int threads)
      : spheres_(spheres),
        bits_(std::min(static_cast<int>(std::bit_width(spheres.size() / usual_size)), most_bits)),
        bands_(spheres.size(), threads),
        entries_(spheres.size()) {
    enter();
  }

  [[nodiscard]] std::size_t count() const { return std::size_t{1} << bits_; }

  /// Adds the spheres of the part that repeat an earlier one. `table` is reused memory.
  void find_repeats(std::size_t part, std::vector<std::uint32_t>& table,
                    std::vector<Repeat>& repeats) const {
    const auto entries =
        std::span(entries_).subspan(begins_[part], begins_[part + 1] - begins_[part]);
    table.assign(std::bit_ceil(2 * entries.size() + 1), empty);
    for (std::uint32_t i = 0; i < entries.size(); ++i) {
      const std::size_t mask = table.size() - 1;
      std::size_t slot = entries[i].tag & mask;
      while (table[slot] != empty && !alike(entries[table[slot]], entries[i])) {
        slot = (slot + 1) & mask;
      }
      if (table[slot] == empty) {
        table[slot] = i;
      } else {
        repeats.push_back({entries[i].place, entries[table[slot]].place});
      }
    }
  }

 private:
  static constexpr std::size_t usual_size = 1U << 13;
  static constexpr int most_bits = 12;
  static constexpr std::uint32_t empty = std::numeric_limits<std::uint32_t>::max();

  [[nodiscard]] std::size_t part_of(std::uint32_t tag) const {
    return static_cast<std::size_t>(std::uint64_t{tag} >> (32 - bits_));
  }

  [[nodiscard]] bool alike(const Entry& a, const Entry& b) const {
    return a.tag == b.tag && same_place(spheres_[a.place], spheres_[b.place]);
  }

  /// Counts the entries of each band for each part, computes their places, and stores the entries
  /// there.
  void enter() {
    std::vector<std::uint32_t> tags(spheres_.size());
    std::vector<std::vector<std::size_t>> next(bands_.count(), std::vector<std::size_t>(count()));
    bands_.run([&](std::size_t band, std::size_t begin, std::size_t end) {
      for (std::size_t i = begin; i < end; ++i) {
        tags[i] = static_cast<std::uint32_t>(hash_of(spheres_[i]) >> 32);
        ++next[band][part_of(tags[i])];
      }
    });
    std::size_t sum = 0;
    for (std::size_t part = 0; part < count(); ++part) {
      begins_.push_back(sum);
      for (std::vector<std::size_t>& of_band : next) sum += std::exchange(of_band[part], sum);
    }
    begins_.push_back(sum);
    bands_.run([&](std::size_t band, std::size_t begin, std::size_t end) {
      for (std::size_t i = begin; i < end; ++i) {
        entries_[next[band][part_of(tags[i])]++] = {tags[i], static_cast<std::uint32_t>(i)};
      }
    });
  }

  const std::vector<Sphere>& spheres_;
  int bits_;
  Bands bands_;
  std::vector<Entry> entries_;
  std::vector<std::size_t> begins_;  // start of each part, and the end of the last part
};

/// Returns the repeats in the order of their places.
std::vector<Repeat> repeats_in(const std::vector<Sphere>& spheres, int threads) {
  const Parts parts(spheres, threads);
  const Bands bands(spheres.size(), threads);  // each thread handles every n-th part
  std::vector<std::vector<Repeat>> found(bands.count());
  bands.run([&](std::size_t band, std::size_t /*begin*/, std::size_t /*end*/) {
    std::vector<std::uint32_t> table;
    for (std::size_t part = band; part < parts.count(); part += bands.count()) {
      parts.find_repeats(part, table, found[band]);
    }
  });
  std::vector<Repeat> all;
  for (const std::vector<Repeat>& some : found) all.insert(all.end(), some.begin(), some.end());
  std::ranges::sort(all, {}, &Repeat::place);
  return all;
}

void erase(const std::vector<Repeat>& repeats, std::vector<Sphere>& spheres) {
  auto next = repeats.begin();
  std::size_t kept = 0;
  for (std::size_t i = 0; i < spheres.size(); ++i) {
    if (next != repeats.end() && next->place == i) {
      ++next;
    } else {
      spheres[kept++] = spheres[i];
    }
  }
  spheres.resize(kept);
}

}  // namespace

void order_materials(Scene& scene) {
  constexpr std::uint32_t none = std::numeric_limits<std::uint32_t>::max();
  std::vector<std::uint32_t> numbers(scene.materials.size(), none);
  std::vector<Material> used;
  const auto renumber = [&](auto& shape) {
    std::uint32_t& number = numbers[shape.material];
    if (number == none) {
      number = static_cast<std::uint32_t>(used.size());
      used.push_back(scene.materials[shape.material]);
    }
    shape.material = number;
  };
  std::ranges::for_each(scene.spheres, renumber);
  std::ranges::for_each(scene.capsules, renumber);
  scene.materials = std::move(used);
}

Duplicates remove_duplicates(Scene& scene, int threads) {
  const std::vector<Repeat> repeats = repeats_in(scene.spheres, threads);
  if (repeats.empty()) return {};
  erase(repeats, scene.spheres);
  order_materials(scene);
  return {repeats.size(), repeats.front().place, repeats.front().of};
}

}  // namespace parray::input
