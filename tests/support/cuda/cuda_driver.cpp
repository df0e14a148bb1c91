#include "tests/support/cuda/cuda_driver.h"

#include <dlfcn.h>

namespace parray::test {

CudaDriver::CudaDriver(const std::string& library) {
  load(library);
  const cuda::Result begun = functions_.cuInit(0);
  if (begun != cuda::success) {
    throw NoDevice("no CUDA device: cuInit failed with " + name_of_error(begun));
  }
  if (device_count() == 0) throw NoDevice("no CUDA device: the driver lists none");
}

CudaDriver::~CudaDriver() = default;  // the library stays loaded: a driver keeps threads of its own

void CudaDriver::load(const std::string& library) {
  library_ = dlopen(library.c_str(), RTLD_NOW | RTLD_LOCAL);
  if (library_ == nullptr) {
    const char* reason = dlerror();  // NOLINT(concurrency-mt-unsafe): glibc keeps one per thread
    throw NoDevice("no CUDA driver: " + std::string(reason == nullptr ? library : reason));
  }
  const auto find = [&](auto& function, const char* name) {
    void* symbol = dlsym(library_, name);
    if (symbol == nullptr)
      throw NoDevice("the CUDA driver is too old: " + library + " lacks " + name);
    function = reinterpret_cast<std::remove_reference_t<decltype(function)>>(symbol);
  };
#define PARRAY_CUDA_FIND(name, ...) find(functions_.name, #name);
  PARRAY_FOR_EACH_CUDA_FUNCTION(PARRAY_CUDA_FIND)
#undef PARRAY_CUDA_FIND
}

std::string CudaDriver::version() const {
  int version = 0;
  cuDriverGetVersion(&version);
  return std::to_string(version / 1000) + "." + std::to_string(version % 1000 / 10);
}

int CudaDriver::device_count() const {
  int count = 0;
  cuDeviceGetCount(&count);
  return count;
}

std::string CudaDriver::name_of_error(cuda::Result error) const {
  const char* name = nullptr;
  if (functions_.cuGetErrorName(error, &name) != cuda::success || name == nullptr) {
    return "error " + std::to_string(error);
  }
  return name;
}

void CudaDriver::check(cuda::Result result, const char* function) const {
  if (result != cuda::success) {
    throw DeviceError(std::string(function) + " failed with " + name_of_error(result));
  }
}

}  // namespace parray::test
