#pragma once

#include <cstdint>

#include "common/rooms.h"

/// The data that a host and a device (a GPU) exchange with every launch of a kernel. Plain structs
/// without pointers: both sides have the same layout. See README.md.
namespace parray::trace {

/// One work item: samples [begin, end) of pixel (x, y).
struct DeviceItem {
  std::uint32_t x;
  std::uint32_t y;
  std::uint32_t begin;
  std::uint32_t end;
};

/// The result of one work item, in the integers of PixelSums and TraceCounts.
struct DeviceSums {
  std::uint64_t sum[3];
  std::uint64_t sum_of_squares[3];
  std::uint64_t odd[3];
  std::uint64_t rays;
  std::uint64_t lost;
  std::uint32_t nonfinite;
  /// 1: a path was inside more shapes at once than the kernel can store. The other members are then
  /// 0, and the CPU has to trace the item. Otherwise 0.
  std::uint32_t handed_back;
};

/// The signature of every kernel. Thread number i of a launch writes the result of items[i] to
/// sums[i], and does nothing if i >= item_count. `scene` and `picture` are copies of
/// DeviceScene::bytes() and DevicePicture::bytes() in the device's memory, aligned to 64 bytes.
using DeviceKernel = void(const void* scene, const void* picture, const DeviceItem* items,
                          std::uint32_t item_count, DeviceSums* sums);

}  // namespace parray::trace
