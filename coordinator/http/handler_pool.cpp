#include "coordinator/http/handler_pool.h"

#include <sys/resource.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <system_error>
#include <utility>

namespace parray::http {

void HandlerPool::give(SharedConnection connection) {
  const std::scoped_lock lock(mutex_);
  if (stopped_) return;
  const std::string owner = owner_of_address(connection->address());
  turns_.push(owner, std::move(connection));
  if (idle_ < turns_.waiting() && threads_.size() < most_) {
    try {
      threads_.emplace_back([this] { work(); });
    } catch (const std::system_error&) {
      // Existing threads do the work. Without any, the next call tries again.
    }
  }
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

void HandlerPool::work() {
  constexpr int low = 5;
  setpriority(PRIO_PROCESS, static_cast<id_t>(syscall(SYS_gettid)), low);
  const Handler handle = make_handler_();
  std::unique_lock lock(mutex_);
  while (!stopped_) {
    std::optional<SharedConnection> connection = turns_.take();
    if (!connection) {
      ++idle_;
      given_.wait(lock);
      --idle_;
      continue;
    }
    const std::string owner = owner_of_address((*connection)->address());
    lock.unlock();
    handle(*connection);
    connection.reset();
    lock.lock();
    turns_.ended(owner);
    if (turns_.waiting() > 0) given_.notify_one();  // a request of this owner may begin now
  }
}

}  // namespace parray::http
