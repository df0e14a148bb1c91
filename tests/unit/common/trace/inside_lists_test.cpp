#include "common/trace/inside_lists.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <iterator>
#include <set>
#include <vector>

#include "tests/support/dice.h"
#include "tests/support/rooms.h"

namespace parray::test {
namespace {

using SphereNumbers = std::multiset<std::uint32_t>;

SphereNumbers contents(const InsideLists& lists, std::uint32_t head) {
  SphereNumbers result;
  for (std::uint32_t link = head; link != InsideLists::none; link = lists.next(link)) {
    result.insert(lists.shape(link));
  }
  return result;
}

/// Lists of many paths, each beside the multiset that it should be.
class Model {
 public:
  explicit Model(std::size_t paths) : heads_(paths, InsideLists::none), expected_(paths) {}

  void push(std::size_t path, std::uint32_t sphere) {
    heads_[path] = lists_.push(heads_[path], sphere);
    expected_[path].insert(sphere);
    ++size_;
    largest_ = std::max(largest_, size_);
  }
  /// Any of the path's spheres, be it first, last or in the middle.
  void remove_one(std::size_t path, Dice& dice) {
    SphereNumbers& spheres = expected_[path];
    if (!spheres.empty()) {
      const auto chosen =
          std::next(spheres.begin(), static_cast<std::ptrdiff_t>(dice.below(spheres.size())));
      heads_[path] = lists_.remove(heads_[path], *chosen);
      spheres.erase(chosen);
      --size_;
    }
  }
  void release(std::size_t path) {
    lists_.release(heads_[path]);
    heads_[path] = InsideLists::none;
    size_ -= expected_[path].size();
    expected_[path].clear();
  }
  void clear() {
    lists_.clear();
    heads_.assign(heads_.size(), InsideLists::none);
    expected_.assign(expected_.size(), {});
    size_ = 0;
  }

  [[nodiscard]] bool good(std::size_t path) const {
    return contents(lists_, heads_[path]) == expected_[path];
  }
  [[nodiscard]] bool all_good() const {
    for (std::size_t path = 0; path < heads_.size(); ++path) {
      if (!good(path)) return false;
    }
    return true;
  }
  [[nodiscard]] std::size_t largest() const { return largest_; }

 private:
  InsideLists lists_;
  std::vector<std::uint32_t> heads_;
  std::vector<SphereNumbers> expected_;
  std::size_t size_ = 0;
  std::size_t largest_ = 0;
};

}  // namespace

TEST_CASE("lists of spheres are multisets, whatever is pushed, removed, released and used again") {
  Dice dice(1);
  Model model(64);
  for (int step = 0; step < 200'000; ++step) {
    const std::size_t path = dice.below(64);
    const bool growing = step / 20'000 % 2 == 0;
    if (dice.one_in(growing ? 2000 : 200)) {
      model.release(path);
    } else if (dice.below(10) < (growing ? 6 : 4)) {
      model.push(path, dice.below32(50));  // often the same sphere twice
    } else {
      model.remove_one(path, dice);
    }
    REQUIRE_UNARY(model.good(path));
    if (step % 5000 == 0) {
      REQUIRE_UNARY(model.all_good());  // no list disturbs another
    }
    if (step == 150'000) {
      model.clear();
      REQUIRE_UNARY(model.all_good());
    }
  }
  CHECK_UNARY(model.all_good());
  CHECK(model.largest() > 2048);  // beyond the pool's first sizes
}

TEST_CASE("a list keeps its spheres when the pool grows under it") {
  InsideLists lists;
  std::uint32_t head = InsideLists::none;
  SphereNumbers expected;
  for (std::uint32_t sphere = 0; sphere < 5000; ++sphere) {
    head = lists.push(head, sphere);
    expected.insert(sphere);
  }
  CHECK(contents(lists, head) == expected);
  for (const std::uint32_t sphere : {4999U, 0U, 1024U, 1023U, 2500U}) {  // both ends, and amid
    head = lists.remove(head, sphere);
    expected.erase(sphere);
    REQUIRE(contents(lists, head) == expected);
  }
}

TEST_CASE("links that were given back are used again before the pool grows") {
  InsideLists lists;
  std::uint32_t head = InsideLists::none;
  for (std::uint32_t sphere = 0; sphere < 10; ++sphere) head = lists.push(head, sphere);
  lists.release(head);
  std::set<std::uint32_t> links;
  head = InsideLists::none;
  for (std::uint32_t sphere = 0; sphere < 10; ++sphere) {
    head = lists.push(head, sphere);
    links.insert(head);
  }
  CHECK(links.size() == 10);
  CHECK(*links.rbegin() == 9);
  head = lists.remove(head, 4);
  CHECK(lists.push(head, 7) < 10);
}

}  // namespace parray::test
