#include "tests/support/cuda/cuda_driver.h"

#include <dlfcn.h>

#include <array>
#include <type_traits>

namespace parray::test {

namespace {

/// Where containers and WSL have the library, if the loader does not find it by its name.
constexpr std::array usual_places{"libcuda.so.1", "/usr/local/nvidia/lib64/libcuda.so.1",
                                  "/usr/lib/wsl/lib/libcuda.so.1"};

}  // namespace

CudaDriver::CudaDriver(const std::string& library) {
  load(library);
  const cuda::Result begun = functions_.cuInit(0);
  if (begun != cuda::success) {
    throw NoDevice("no CUDA device: cuInit failed with " + name_of_error(begun));
  }
  if (device_count() == 0) throw NoDevice("no CUDA device: the driver lists none");
}

void CudaDriver::load(const std::string& library) {
  std::string reason;
  for (const std::string place : usual_places) {
    const std::string& file = library.empty() ? place : library;
    library_ = dlopen(file.c_str(), RTLD_NOW | RTLD_LOCAL);
    if (library_ != nullptr) return find_functions(file);
    const char* error = dlerror();  // NOLINT(concurrency-mt-unsafe): glibc keeps one per thread
    if (reason.empty()) reason = error == nullptr ? file : error;
  }
  throw NoDevice("no CUDA driver: " + reason);
}

void CudaDriver::find_functions(const std::string& library) {
  const auto find = [&](auto& function, const char* name) {
    void* symbol = dlsym(library_, name);
    if (symbol == nullptr) {
      throw NoDevice("the CUDA driver is too old: " + library + " lacks " + name);
    }
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
