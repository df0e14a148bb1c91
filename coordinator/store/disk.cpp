#include "coordinator/store/disk.h"

#include <unistd.h>

#include <cstdio>

namespace parray::store {

ssize_t Disk::write(int file, std::string_view bytes, std::uint64_t offset) {
  return pwrite(file, bytes.data(), bytes.size(), static_cast<off_t>(offset));
}

int Disk::sync(int file) { return fdatasync(file); }

int Disk::sync_directory(int directory) { return fsync(directory); }

int Disk::sync_file_system(int directory) { return syncfs(directory); }

int Disk::rename(const char* from, const char* onto) { return std::rename(from, onto); }

Disk& system_disk() {
  static Disk disk;
  return disk;
}

}  // namespace parray::store
