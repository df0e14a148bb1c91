#pragma once

#include <memory>
#include <utility>

#include "common/rooms.h"

namespace parray::base {

/// A value of type T on the heap: copies are deep, and two boxes are equal if their values are. A
/// header that holds a `Boxed<T>` needs only a declaration of T, so that a change of T does not
/// rebuild the users of that header.
///
/// Only the operators of the first group work without the definition of T. For the other members, a
/// header that declares T without defining it also declares `extern template class base::Boxed<T>`.
/// One source file includes the definition of T and instantiates the class. Then every source file
/// that includes the header can copy, move, compare and destroy boxes.
template <typename T>
class Boxed {
 public:
  [[nodiscard]] const T& operator*() const { return *value_; }
  [[nodiscard]] T& operator*() { return *value_; }
  const T* operator->() const { return value_.get(); }
  T* operator->() { return value_.get(); }
  operator const T&() const { return *value_; }  // NOLINT(google-explicit-constructor)
  operator T&() { return *value_; }              // NOLINT(google-explicit-constructor)

  /// Holds T{}.
  Boxed();
  Boxed(const T& value);  // NOLINT(google-explicit-constructor): a box stands for its value
  Boxed(T&& value);       // NOLINT(google-explicit-constructor)
  Boxed(const Boxed& other);
  /// Leaves `other` without a value: then it may only be assigned to or destroyed.
  Boxed(Boxed&& other) noexcept;
  Boxed& operator=(const Boxed& other);
  Boxed& operator=(Boxed&& other) noexcept;
  ~Boxed();

  bool operator==(const Boxed& other) const;
  bool operator==(const T& other) const;

 private:
  std::unique_ptr<T> value_;  ///< null only after a move
};

// Not inline: `extern template` leaves only such members to the source that defines the instance.
template <typename T>
Boxed<T>::Boxed() : value_(std::make_unique<T>()) {}
template <typename T>
Boxed<T>::Boxed(const T& value) : value_(std::make_unique<T>(value)) {}
template <typename T>
Boxed<T>::Boxed(T&& value) : value_(std::make_unique<T>(std::move(value))) {}
template <typename T>
Boxed<T>::Boxed(const Boxed& other) : value_(std::make_unique<T>(*other.value_)) {}
template <typename T>
Boxed<T>::Boxed(Boxed&& other) noexcept = default;
template <typename T>
Boxed<T>& Boxed<T>::operator=(const Boxed& other) {
  if (this != &other) value_ = std::make_unique<T>(*other.value_);
  return *this;
}
template <typename T>
Boxed<T>& Boxed<T>::operator=(Boxed&& other) noexcept = default;
template <typename T>
Boxed<T>::~Boxed() = default;
template <typename T>
bool Boxed<T>::operator==(const Boxed& other) const {
  return *value_ == *other.value_;
}
template <typename T>
bool Boxed<T>::operator==(const T& other) const {
  return *value_ == other;
}

}  // namespace parray::base
