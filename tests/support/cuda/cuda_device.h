#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <type_traits>
#include <utility>

#include "tests/support/cuda/cuda_driver.h"

/// A CUDA device: memory, copies, launches and times. One thread uses a device and its objects.
/// Objects of a device must end before the device. Every function may throw DeviceError.
namespace parray::test {

struct DeviceFacts {
  std::string name;
  std::string driver;  ///< version of CUDA that the driver supports
  int capability_major = 0;
  int capability_minor = 0;
  int multiprocessors = 0;
  std::uint64_t memory = 0;    ///< bytes
  std::uint64_t l2 = 0;        ///< bytes
  double clock_mhz = 0;        ///< the highest clock
  double memory_gb_per_s = 0;  ///< by clock and width of the bus; 0: unknown
  bool ecc = false;
};

/// A block of the device's memory, aligned to 256 bytes.
class CudaMemory {
 public:
  CudaMemory() = default;
  /// Takes at least one byte.
  CudaMemory(const CudaDriver& driver, std::size_t bytes);
  /// Takes as many bytes as `data` has, and copies them.
  CudaMemory(const CudaDriver& driver, std::span<const std::byte> data);
  ~CudaMemory() { free(); }
  CudaMemory(CudaMemory&& other) noexcept { *this = std::move(other); }
  CudaMemory& operator=(CudaMemory&& other) noexcept;

  /// Copies to the bytes from `begin` on.
  void copy_in(std::span<const std::byte> data, std::size_t begin = 0);
  /// Copies the bytes from `begin` on. Waits for earlier launches.
  void copy_out(std::span<std::byte> data, std::size_t begin = 0) const;
  /// Returns the address, as a parameter of kernels.
  [[nodiscard]] cuda::Pointer address() const { return address_; }
  [[nodiscard]] std::size_t size() const { return size_; }

 private:
  void free() noexcept;

  const CudaDriver* driver_ = nullptr;
  cuda::Pointer address_ = 0;
  std::size_t size_ = 0;
};

/// A kernel of a loaded module.
struct CudaKernel {
  cuda::Function function = nullptr;
  int registers = 0;    ///< of a thread
  int local_bytes = 0;  ///< of a thread, in the device's memory
};

/// A text in PTX that the driver has compiled for the device.
class CudaModule {
 public:
  /// Compiles the text. `most_registers`: most registers of a thread; 0: the compiler chooses. The
  /// compiler's messages become a part of an exception.
  CudaModule(const CudaDriver& driver, const std::string& ptx, int most_registers = 0);
  ~CudaModule();
  CudaModule& operator=(CudaModule&&) = delete;

  [[nodiscard]] CudaKernel kernel(const std::string& name) const;

 private:
  const CudaDriver& driver_;
  cuda::Module module_ = nullptr;
};

/// Measures the device's time between two points of its work.
class CudaTimer {
 public:
  explicit CudaTimer(const CudaDriver& driver);
  ~CudaTimer();
  CudaTimer& operator=(CudaTimer&&) = delete;

  void start() { driver_.cuEventRecord(begin_, cuda::Stream{}); }
  void stop() { driver_.cuEventRecord(end_, cuda::Stream{}); }
  /// Waits for the point of stop() and returns the time since start().
  [[nodiscard]] double seconds() const;

 private:
  const CudaDriver& driver_;
  cuda::Event begin_ = nullptr;
  cuda::Event end_ = nullptr;
};

class CudaDevice {
 public:
  /// Throws NoDevice if there is no device with this number.
  CudaDevice(const CudaDriver& driver, int number);
  ~CudaDevice();
  CudaDevice& operator=(CudaDevice&&) = delete;

  [[nodiscard]] const CudaDriver& driver() const { return driver_; }
  [[nodiscard]] const DeviceFacts& facts() const { return facts_; }
  /// Returns how many blocks of threads a multiprocessor runs at once.
  [[nodiscard]] int blocks_at_once(const CudaKernel& kernel, int block_threads) const;

  /// Begins a launch of at least `threads` threads in blocks of `block_threads`. `arguments` have
  /// the types of the kernel's parameters; addresses are cuda::Pointer. Errors of the kernel itself
  /// appear in a later call.
  template <typename... Arguments>
  void launch(const CudaKernel& kernel, std::uint32_t threads, std::uint32_t block_threads,
              Arguments... arguments) const {
    static_assert((std::is_trivially_copyable_v<Arguments> && ...));
    void* parameters[] = {&arguments...};
    const std::uint32_t blocks = (threads + block_threads - 1) / block_threads;
    driver_.cuLaunchKernel(kernel.function, blocks, 1U, 1U, block_threads, 1U, 1U, 0U,
                           cuda::Stream{}, parameters, static_cast<void**>(nullptr));
  }
  /// Waits until all launches have ended.
  void wait() const { driver_.cuCtxSynchronize(); }

 private:
  /// Returns 0 if the driver does not know the attribute.
  [[nodiscard]] int attribute(cuda::DeviceAttribute attribute) const;
  void read_facts();

  const CudaDriver& driver_;
  cuda::DeviceNumber device_ = 0;
  DeviceFacts facts_;
};

}  // namespace parray::test
