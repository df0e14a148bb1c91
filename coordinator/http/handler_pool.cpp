#include "coordinator/http/handler_pool.h"

#include <sys/resource.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <system_error>
#include <utility>

namespace parray::http {

void HandlerPool::give(Guest guest) {
  const std::scoped_lock lock(mutex_);
  if (stopped_) return;
  const std::string owner = owner_of_address(guest->address());
  turns_.push(owner, std::move(guest));
  if (idle_ < turns_.waiting() && threads_.size() < most_) add_thread();
  given_.notify_one();
}

void HandlerPool::stop() {
  std::vector<std::thread> threads;
  {
    const std::scoped_lock lock(mutex_);
    stopped_ = true;
    threads = std::exchange(threads_, {});
  }
  given_.notify_all();
  for (std::thread& thread : threads) thread.join();
}

/// Where the system allows no more, those that there are do all; with none it is tried again.
void HandlerPool::add_thread() {
  try {
    threads_.emplace_back([this] { work(); });
  } catch (const std::system_error&) {
    return;
  }
}

void HandlerPool::work() {
  constexpr int low = 5;
  setpriority(PRIO_PROCESS, static_cast<id_t>(syscall(SYS_gettid)), low);
  const Handler handle = make_handler_();
  std::unique_lock lock(mutex_);
  while (!stopped_) {
    std::optional<Guest> guest = turns_.take();
    if (!guest) {
      ++idle_;
      given_.wait(lock);
      --idle_;
      continue;
    }
    const std::string owner = owner_of_address((*guest)->address());
    lock.unlock();
    handle(*guest);
    guest.reset();
    lock.lock();
    turns_.ended(owner);
    if (turns_.waiting() > 0) given_.notify_one();  // it may have waited for this one
  }
}

}  // namespace parray::http
