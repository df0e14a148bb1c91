#include "common/base/module.h"

#include <dlfcn.h>

#include <filesystem>
#include <system_error>

#include "common/base/error.h"

namespace parray::base {

namespace fs = std::filesystem;

fs::path module_file(const std::string& name) {
  std::error_code error;
  const fs::path program = fs::read_symlink("/proc/self/exe", error);
  if (error) {
    throw RunError("/proc/self/exe cannot be read (" + error.message() +
                   "), so the program does not find its modules: mount /proc");
  }
  fs::path beside = program.parent_path() / name;
  if (fs::exists(beside, error)) return beside;
  return program.parent_path().parent_path() / "lib" / "parray" / name;
}

void* module_entry(const std::string& file, const char* entry, const std::string& what,
                   const std::string& remedy) {
  void* const module = dlopen(module_file(file).c_str(), RTLD_NOW | RTLD_LOCAL);
  void* const found = module == nullptr ? nullptr : dlsym(module, entry);
  if (found == nullptr) {
    // NOLINTNEXTLINE(concurrency-mt-unsafe): each thread has its own error text
    throw RunError("loading " + what + ": " + std::string(dlerror()) + ": " + remedy);
  }
  return found;
}

}  // namespace parray::base
