#include "common/base/boxed.h"

#include <doctest/doctest.h>

#include <string>
#include <type_traits>
#include <utility>
#include <vector>

namespace parray::base {

// Declares a value whose definition follows, as headers do that hold boxes.
struct BoxedValue;

}  // namespace parray::base

extern template class parray::base::Boxed<parray::base::BoxedValue>;

namespace parray::base {
namespace {

/// A record that knows only the declaration of its value.
struct Holder {
  std::string name;
  Boxed<BoxedValue> value;

  friend bool operator==(const Holder&, const Holder&) = default;
};

static_assert(std::is_copy_constructible_v<Holder> && std::is_copy_assignable_v<Holder>);
static_assert(std::is_nothrow_move_constructible_v<Holder>);
static_assert(std::is_nothrow_move_assignable_v<Holder>);

const BoxedValue& passed_on(const Holder& holder) { return holder.value; }

}  // namespace

struct BoxedValue {
  int number = 7;
  std::vector<int> list{};

  friend bool operator==(const BoxedValue&, const BoxedValue&) = default;
};

namespace {

TEST_CASE("a box holds the default value at first, and takes and gives values") {
  Boxed<BoxedValue> box;
  CHECK(box->number == 7);
  CHECK(box == BoxedValue{});
  box->list = {1, 2};
  const BoxedValue copy = box;
  CHECK(copy.list == std::vector<int>{1, 2});
  box = BoxedValue{3, {}};
  CHECK((*box).number == 3);
  BoxedValue& inside = box;
  inside.number = 4;
  CHECK(box->number == 4);
  CHECK(&passed_on({"", box}) != &inside);
}

TEST_CASE("copies of a box are deep, and equal while their values are") {
  Holder one{"one", BoxedValue{1, {5}}};
  Holder two = one;
  CHECK(one == two);
  two.value->list.push_back(6);
  CHECK(one.value->list == std::vector<int>{5});
  CHECK_FALSE(one == two);
  one = two;
  CHECK(one == two);
  one = std::as_const(one);  // to itself
  CHECK(one == two);
  CHECK_FALSE(one.value == BoxedValue{});
}

TEST_CASE("a moved box hands over its value and may be assigned to") {
  std::vector<Holder> holders(2);
  holders[0].value->number = 1;
  const BoxedValue* const value = &*holders[0].value;
  Holder taken = std::move(holders[0]);
  CHECK(&*taken.value == value);
  holders[0] = Holder{"again", BoxedValue{2, {}}};
  CHECK(holders[0].value->number == 2);
  holders[1] = std::move(taken);
  CHECK(holders[1].value->number == 1);
}

}  // namespace
}  // namespace parray::base

template class parray::base::Boxed<parray::base::BoxedValue>;
