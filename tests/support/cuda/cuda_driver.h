#pragma once

#include <stdexcept>
#include <string>

#include "common/base/error.h"
#include "tests/support/cuda/cuda_functions.h"

namespace parray::test {

/// The machine has no driver library or no device. what() is one line.
class NoDevice : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// A function of the driver failed. what() is one line with the names of the function and error.
class DeviceError : public RunError {
 public:
  using RunError::RunError;
};

/// CUDA's driver library, loaded at run time. A program links no library of CUDA and needs no
/// toolkit. Any thread may call its functions.
class CudaDriver {
 public:
  /// Loads `library`; empty: the driver's library where systems have it. Throws NoDevice if the
  /// library cannot be loaded, lacks a function, or finds no device.
  explicit CudaDriver(const std::string& library = "");
  ~CudaDriver() = default;  // the library stays loaded: it keeps threads of its own
  CudaDriver& operator=(CudaDriver&&) = delete;

  /// Returns the version of CUDA that the driver supports, such as "13.0".
  [[nodiscard]] std::string version() const;
  [[nodiscard]] int device_count() const;

  /// The functions of the library under their own names. They throw DeviceError.
#define PARRAY_CUDA_CALL(name, ...)              \
  template <typename... Arguments>               \
  void name(Arguments... arguments) const {      \
    check(functions_.name(arguments...), #name); \
  }
  PARRAY_FOR_EACH_CUDA_FUNCTION(PARRAY_CUDA_CALL)
#undef PARRAY_CUDA_CALL

  /// The functions without a check, for destructors.
  [[nodiscard]] const cuda::Functions& unchecked() const { return functions_; }
  /// Returns the driver's name of an error, such as CUDA_ERROR_OUT_OF_MEMORY.
  [[nodiscard]] std::string name_of_error(cuda::Result error) const;

 private:
  void load(const std::string& library);
  void find_functions(const std::string& library);
  void check(cuda::Result result, const char* function) const;

  void* library_ = nullptr;
  cuda::Functions functions_;
};

}  // namespace parray::test
