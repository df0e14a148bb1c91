#include "tests/support/cuda/cuda_device.h"

#include <algorithm>
#include <array>
#include <bit>
#include <utility>

namespace parray::test {

CudaMemory::CudaMemory(const CudaDriver& driver, std::size_t bytes)
    : driver_(&driver), size_(std::max<std::size_t>(bytes, 1)) {
  try {
    driver.cuMemAlloc_v2(&address_, size_);
  } catch (const DeviceError& error) {
    throw DeviceError(std::string(error.what()) + ": the kernels need " + std::to_string(size_) +
                      " more bytes of the device's memory");
  }
}

CudaMemory::CudaMemory(const CudaDriver& driver, std::span<const std::byte> data)
    : CudaMemory(driver, data.size()) {
  copy_in(data);
}

CudaMemory& CudaMemory::operator=(CudaMemory&& other) noexcept {
  if (this != &other) {
    free();
    driver_ = std::exchange(other.driver_, nullptr);
    address_ = std::exchange(other.address_, 0);
    size_ = std::exchange(other.size_, 0);
  }
  return *this;
}

void CudaMemory::free() noexcept {
  if (address_ != 0) driver_->unchecked().cuMemFree_v2(address_);
}

void CudaMemory::copy_in(std::span<const std::byte> data, std::size_t begin) {
  if (!data.empty()) {
    driver_->cuMemcpyHtoD_v2(address_ + begin, static_cast<const void*>(data.data()), data.size());
  }
}

void CudaMemory::copy_out(std::span<std::byte> data, std::size_t begin) const {
  if (!data.empty()) {
    driver_->cuMemcpyDtoH_v2(static_cast<void*>(data.data()), address_ + begin, data.size());
  }
}

CudaModule::CudaModule(const CudaDriver& driver, const std::string& ptx, int most_registers)
    : driver_(driver) {
  std::array<char, 2048> log{};
  std::array options{cuda::error_log, cuda::error_log_bytes, cuda::most_registers};
  // Numbers are passed in place of addresses.
  std::array<void*, 3> values{log.data(), std::bit_cast<void*>(log.size()),
                              std::bit_cast<void*>(static_cast<std::uintptr_t>(most_registers))};
  const unsigned count = most_registers > 0 ? 3 : 2;
  try {
    driver.cuModuleLoadDataEx(&module_, static_cast<const void*>(ptx.c_str()), count,
                              options.data(), values.data());
  } catch (const DeviceError& error) {
    log.back() = '\0';
    throw DeviceError(std::string(error.what()) + ": " + log.data());
  }
}

CudaModule::~CudaModule() { driver_.unchecked().cuModuleUnload(module_); }

CudaKernel CudaModule::kernel(const std::string& name) const {
  CudaKernel kernel;
  try {
    driver_.cuModuleGetFunction(&kernel.function, module_, name.c_str());
  } catch (const DeviceError& error) {
    throw DeviceError(std::string(error.what()) + ": the device code has no kernel " + name);
  }
  driver_.cuFuncGetAttribute(&kernel.registers, cuda::registers, kernel.function);
  driver_.cuFuncGetAttribute(&kernel.local_bytes, cuda::local_bytes, kernel.function);
  return kernel;
}

CudaTimer::CudaTimer(const CudaDriver& driver) : driver_(driver) {
  driver.cuEventCreate(&begin_, 0U);
  try {
    driver.cuEventCreate(&end_, 0U);
  } catch (...) {
    driver.unchecked().cuEventDestroy_v2(begin_);
    throw;
  }
}

CudaTimer::~CudaTimer() {
  driver_.unchecked().cuEventDestroy_v2(begin_);
  driver_.unchecked().cuEventDestroy_v2(end_);
}

double CudaTimer::seconds() const {
  float milliseconds = 0;
  driver_.cuEventSynchronize(end_);
  driver_.cuEventElapsedTime(&milliseconds, begin_, end_);
  return static_cast<double>(milliseconds) / 1e3;
}

CudaDevice::CudaDevice(const CudaDriver& driver, int number) : driver_(driver) {
  const int count = driver.device_count();
  if (number >= count) {
    throw NoDevice("no CUDA device " + std::to_string(number) + ": the driver lists " +
                   std::to_string(count) + ", from 0 on");
  }
  driver.cuDeviceGet(&device_, number);
  read_facts();
  cuda::Context context = nullptr;
  driver.cuDevicePrimaryCtxRetain(&context, device_);
  driver.cuCtxSetCurrent(context);
}

CudaDevice::~CudaDevice() {
  driver_.unchecked().cuCtxSetCurrent(nullptr);
  driver_.unchecked().cuDevicePrimaryCtxRelease_v2(device_);
}

int CudaDevice::attribute(cuda::DeviceAttribute attribute) const {
  int value = 0;
  const cuda::Result found = driver_.unchecked().cuDeviceGetAttribute(&value, attribute, device_);
  return found == cuda::success ? value : 0;
}

void CudaDevice::read_facts() {
  std::array<char, 256> name{};
  driver_.cuDeviceGetName(name.data(), static_cast<int>(name.size()), device_);
  std::size_t memory = 0;
  driver_.cuDeviceTotalMem_v2(&memory, device_);
  facts_.name = name.data();
  facts_.driver = driver_.version();
  facts_.capability_major = attribute(cuda::capability_major);
  facts_.capability_minor = attribute(cuda::capability_minor);
  facts_.multiprocessors = attribute(cuda::multiprocessors);
  facts_.memory = memory;
  facts_.l2 = static_cast<std::uint64_t>(attribute(cuda::l2_bytes));
  facts_.clock_mhz = attribute(cuda::clock_khz) / 1e3;
  // Two transfers in each cycle.
  facts_.memory_gb_per_s =
      2e-6 * attribute(cuda::memory_clock_khz) * attribute(cuda::memory_bus_bits) / 8;
  facts_.ecc = attribute(cuda::ecc) != 0;
}

int CudaDevice::blocks_at_once(const CudaKernel& kernel, int block_threads) const {
  int blocks = 0;
  driver_.cuOccupancyMaxActiveBlocksPerMultiprocessor(&blocks, kernel.function, block_threads,
                                                      std::size_t{0});
  return blocks;
}

}  // namespace parray::test
