#include "cli/input/particles/particle_columns.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "cli/input/particles/guess_element.h"
#include "cli/output/picture/srgb.h"
#include "common/base/printable.h"
#include "common/scene/limits.h"

namespace parray::input {
namespace {

/// Appends a value. Reserves the expected size first.
template <typename T>
void append(std::vector<T>& column, const T& value, std::size_t expected) {
  if (column.empty()) column.reserve(expected);
  column.push_back(value);
}

void resize_column(auto& column, std::size_t count, std::size_t expected) {
  if (column.empty()) column.reserve(std::max(count, expected));
  column.resize(count);
}

bool any_component(const Vec3d& v, const auto& predicate) {
  return predicate(v.x) || predicate(v.y) || predicate(v.z);
}

bool is_byte(double value) { return value >= 0 && value <= 255 && std::floor(value) == value; }

std::string range_text(double low, double high) {
  return "use a number from " + number_text(low) + " to " + number_text(high);
}

}  // namespace

void ParticleColumns::check_position(const Vec3d& position) const {
  for (const double value : {position.x, position.y, position.z}) {
    if (std::abs(value) <= limits::max_length) continue;  // false for NaN
    place_->fail(
        "coordinate " + number_text(value) +
        " is out of range: " + range_text(-limits::max_length, limits::max_length) +
        (std::isfinite(value) ? ", or scale all lengths, for example from metres to parsecs" : ""));
  }
}

void ParticleColumns::position(const Vec3d& position) {
  check_position(position);
  if (count() == limits::max_shapes) {
    place_->fail("more than " + std::to_string(limits::max_shapes) + " particles: split the file");
  }
  append(particles_.positions, position, expected_);
}

void ParticleColumns::resize(std::size_t count, bool have_radii, bool have_colors) {
  resize_column(particles_.positions, count, expected_);
  if (have_radii) resize_column(particles_.radii, count, expected_);
  if (have_colors) resize_column(particles_.colors, count, expected_);
  for (NumberColumn& column : particles_.numbers) resize_column(column.values, count, expected_);
}

void ParticleColumns::radius(double radius) {
  if (!(radius >= limits::min_radius && radius <= limits::max_length)) {
    place_->fail("radius " + number_text(radius) +
                 " is out of range: " + range_text(limits::min_radius, limits::max_length));
  }
  append(particles_.radii, radius, expected_);
}

void ParticleColumns::color(const Vec3d& color, ColorScale scale) {
  const double most = scale == ColorScale::linear ? 1 : 255;
  const bool whole = scale == ColorScale::srgb8;
  for (const double value : {color.x, color.y, color.z}) {
    if (value >= 0 && value <= most && (!whole || is_byte(value))) continue;
    place_->fail("colour component " + number_text(value) + " is out of range: use a " +
                 (whole ? "whole number" : "number") + " from 0 to " + number_text(most));
  }
  if (scale == ColorScale::either) check_scale(color);
  append(particles_.colors, whole ? linear_of_srgb8(color) : color, expected_);
}

/// Records the scale that a colour of `either` scale must have. Fails if a file uses both scales.
void ParticleColumns::check_scale(const Vec3d& color) {
  if (!above_one_ && any_component(color, [](double c) { return c > 1; })) {
    above_one_ = place_->number;
  }
  if (!fraction_ && any_component(color, [](double c) { return !is_byte(c); })) {
    fraction_ = place_->number;
  }
  if (above_one_ && fraction_) {
    place_->fail("the file mixes two colour scales (fractions on line " +
                 std::to_string(*fraction_) + ", above 1 on line " + std::to_string(*above_one_) +
                 "): use 0 to 1 for all colours, or whole numbers 0 to 255 for all");
  }
}

void ParticleColumns::element(std::uint8_t atomic_number) {
  any_element_ = any_element_ || atomic_number != 0;
  append(particles_.elements, atomic_number, expected_);
}

void ParticleColumns::type(std::string_view name) {
  auto known = type_index_.find(name);
  if (known == type_index_.end()) {
    if (name.size() > max_type_bytes) {
      place_->fail("the type '" + printable(name) + "' is longer than " +
                   std::to_string(max_type_bytes) + " bytes: shorten it");
    }
    if (type_index_.size() == max_types) {
      place_->fail("more than " + std::to_string(max_types) +
                   " types: check that this column contains types, not names");
    }
    const auto index = static_cast<std::uint32_t>(type_index_.size());
    known = type_index_.emplace(name, index).first;
    particles_.types.names.emplace_back(name);
  }
  append(particles_.types.index, known->second, expected_);
}

std::size_t ParticleColumns::add_numbers(std::string name, std::string unit) {
  particles_.numbers.push_back({std::move(name), {}, std::move(unit)});
  particles_.numbers.back().values.reserve(expected_);
  return particles_.numbers.size() - 1;
}

Particles ParticleColumns::finish() {
  if (count() == 0) place_->fail("the file has no particles: check that this is the right file");
  return finish_frame();
}

void ParticleColumns::unknown_element() {
  ++unknown_elements_;
  element(0);
}

Particles ParticleColumns::finish_frame() {
  if (any_element_ && unknown_elements_ > 0) {
    particles_.facts.notes.push_back(unknown_elements_note(unknown_elements_));
  }
  unknown_elements_ = 0;
  if (!any_element_) particles_.elements = {};
  std::erase_if(particles_.numbers, [](const NumberColumn& column) {
    return std::ranges::all_of(column.values, [](double value) { return std::isnan(value); });
  });
  if (above_one_) {
    for (Vec3d& color : particles_.colors) color = linear_of_srgb8(color);
  }
  return std::move(particles_);
}

void NameIndex::add(std::string_view name, const FilePlace& place) {
  // Neighbouring particles usually share chain and residue.
  if (!column_.index.empty() && column_.names[column_.index.back()] == name) {
    column_.index.push_back(column_.index.back());
    return;
  }
  if (name.size() > max_bytes) {
    place.fail("the name '" + printable(name) + "' is longer than " + std::to_string(max_bytes) +
               " bytes: shorten it");
  }
  column_.index.push_back(number_of(name));
}

std::uint32_t NameIndex::number_of(std::string_view name) {
  auto known = numbers_.find(name);
  if (known == numbers_.end()) {
    known = numbers_.emplace(std::string(name), static_cast<std::uint32_t>(numbers_.size())).first;
    column_.names.emplace_back(name);
  }
  return known->second;
}

void NameIndex::drop_unused() {
  const NameColumn before = std::exchange(column_, {});
  numbers_.clear();
  for (const std::uint32_t index : before.index) {
    column_.index.push_back(number_of(before.names[index]));
  }
}

NameColumn NameIndex::finish() { return unnamed() ? NameColumn{} : std::move(column_); }

}  // namespace parray::input
