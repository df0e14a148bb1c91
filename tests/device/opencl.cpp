#include "tests/device/opencl.h"

#include <algorithm>
#include <fstream>
#include <iterator>
#include <map>
#include <stdexcept>
#include <vector>

#ifdef PARRAY_OPENCL
#define CL_TARGET_OPENCL_VERSION 120
#include <CL/cl.h>

namespace parray::test {
namespace {

void check(cl_int status, const std::string& what) {
  if (status != CL_SUCCESS) {
    throw std::runtime_error(what + " failed with OpenCL error " + std::to_string(status));
  }
}

std::string text_of(cl_device_id device, cl_device_info name) {
  std::size_t size = 0;
  clGetDeviceInfo(device, name, 0, nullptr, &size);
  std::string text(size, '\0');
  clGetDeviceInfo(device, name, size, text.data(), nullptr);
  return text;
}

bool rounds_correctly(cl_device_id device) {
  cl_device_fp_config single = 0;
  cl_device_fp_config twice = 0;
  clGetDeviceInfo(device, CL_DEVICE_SINGLE_FP_CONFIG, sizeof single, &single, nullptr);
  clGetDeviceInfo(device, CL_DEVICE_DOUBLE_FP_CONFIG, sizeof twice, &twice, nullptr);
  constexpr cl_device_fp_config needed =
      CL_FP_CORRECTLY_ROUNDED_DIVIDE_SQRT | CL_FP_DENORM | CL_FP_ROUND_TO_NEAREST;
  return (single & needed) == needed && (twice & CL_FP_DENORM) != 0;
}

/// Returns the first device that can take SPIR, or null.
cl_device_id find_device() {
  cl_uint count = 0;
  if (clGetPlatformIDs(0, nullptr, &count) != CL_SUCCESS || count == 0) return nullptr;
  std::vector<cl_platform_id> platforms(count);
  clGetPlatformIDs(count, platforms.data(), nullptr);
  for (cl_platform_id platform : platforms) {
    cl_uint devices = 0;
    if (clGetDeviceIDs(platform, CL_DEVICE_TYPE_ALL, 0, nullptr, &devices) != CL_SUCCESS) continue;
    std::vector<cl_device_id> all(devices);
    clGetDeviceIDs(platform, CL_DEVICE_TYPE_ALL, devices, all.data(), nullptr);
    for (cl_device_id device : all) {
      const bool takes_spir =
          text_of(device, CL_DEVICE_EXTENSIONS).find("cl_khr_spir") != std::string::npos;
      if (takes_spir && rounds_correctly(device)) return device;
    }
  }
  return nullptr;
}

}  // namespace

struct OpenCl::State {
  cl_context context = nullptr;
  cl_command_queue queue = nullptr;
  cl_program program = nullptr;
  std::map<std::string, cl_kernel> kernels;

  ~State() {
    for (const auto& [name, kernel] : kernels) clReleaseKernel(kernel);
    if (program != nullptr) clReleaseProgram(program);
    if (queue != nullptr) clReleaseCommandQueue(queue);
    if (context != nullptr) clReleaseContext(context);
  }

  cl_kernel kernel(const std::string& name) {
    const auto known = kernels.find(name);
    if (known != kernels.end()) return known->second;
    cl_int status = 0;
    cl_kernel made = clCreateKernel(program, name.c_str(), &status);
    check(status, "clCreateKernel of " + name);
    return kernels[name] = made;
  }
};

std::string OpenCl::reason_without(const std::string& file) {
  if (!std::ifstream(file)) return "the build has no " + file + " (it needs clang and llvm-spirv)";
  if (find_device() == nullptr) return "no OpenCL device takes SPIR (pocl-opencl-icd has one)";
  return "";
}

OpenCl::OpenCl(const std::string& file) : state_(std::make_unique<State>()) {
  if (const std::string reason = reason_without(file); !reason.empty()) {
    throw std::runtime_error(reason);
  }
  cl_device_id device = find_device();
  std::ifstream in(file, std::ios::binary);
  const std::vector<unsigned char> code((std::istreambuf_iterator<char>(in)), {});
  cl_int status = 0;
  state_->context = clCreateContext(nullptr, 1, &device, nullptr, nullptr, &status);
  check(status, "clCreateContext");
  state_->queue = clCreateCommandQueue(state_->context, device, 0, &status);
  check(status, "clCreateCommandQueue");
  const std::size_t size = code.size();
  const unsigned char* data = code.data();
  state_->program =
      clCreateProgramWithBinary(state_->context, 1, &device, &size, &data, nullptr, &status);
  check(status, "clCreateProgramWithBinary");
  status = clBuildProgram(state_->program, 1, &device,
                          "-x spir -spir-std=1.2 -cl-fp32-correctly-rounded-divide-sqrt", nullptr,
                          nullptr);
  check(status, "clBuildProgram");
}

OpenCl::~OpenCl() = default;

void OpenCl::run(const Launch& launch) {
  cl_int status = 0;
  const auto buffer = [&](const void* data, std::size_t bytes, cl_mem_flags flags) {
    // Without const, because OpenCL has one type for both directions.
    cl_mem made = clCreateBuffer(state_->context, flags | CL_MEM_COPY_HOST_PTR,
                                 std::max<std::size_t>(bytes, 1), const_cast<void*>(data), &status);
    check(status, "clCreateBuffer");
    return made;
  };
  cl_mem buffers[] = {buffer(launch.scene.data(), launch.scene.size(), CL_MEM_READ_ONLY),
                      buffer(launch.picture.data(), launch.picture.size(), CL_MEM_READ_ONLY),
                      buffer(launch.items.data(), launch.items.size_bytes(), CL_MEM_READ_ONLY),
                      buffer(launch.sums.data(), launch.sums.size_bytes(), CL_MEM_READ_WRITE)};
  const auto count = static_cast<cl_uint>(launch.items.size());
  cl_kernel kernel = state_->kernel(launch.kernel);
  for (cl_uint i = 0; i < 3; ++i) clSetKernelArg(kernel, i, sizeof(cl_mem), &buffers[i]);
  clSetKernelArg(kernel, 3, sizeof count, &count);
  clSetKernelArg(kernel, 4, sizeof(cl_mem), &buffers[3]);
  constexpr std::size_t group = 16;
  const std::size_t threads = (count + group - 1) / group * group;
  check(clEnqueueNDRangeKernel(state_->queue, kernel, 1, nullptr, &threads, &group, 0, nullptr,
                               nullptr),
        "clEnqueueNDRangeKernel of " + launch.kernel);
  check(clEnqueueReadBuffer(state_->queue, buffers[3], CL_TRUE, 0, launch.sums.size_bytes(),
                            launch.sums.data(), 0, nullptr, nullptr),
        "clEnqueueReadBuffer");
  for (cl_mem memory : buffers) clReleaseMemObject(memory);
}

}  // namespace parray::test

#else

namespace parray::test {

struct OpenCl::State {};
std::string OpenCl::reason_without(const std::string&) {
  return "the build has no OpenCL (ocl-icd-opencl-dev and opencl-headers have it)";
}
OpenCl::OpenCl(const std::string& file) { throw std::runtime_error(reason_without(file)); }
OpenCl::~OpenCl() = default;
void OpenCl::run(const Launch&) {}

}  // namespace parray::test

#endif
