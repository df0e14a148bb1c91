#include "proto/address_list.h"

#include <algorithm>
#include <cstdint>
#include <limits>
#include <sstream>
#include <string_view>

#include "common/base/error.h"
#include "common/base/text.h"

namespace parray::proto {

bool has_port(const std::string& address) {
  if (!address.starts_with("tcp://")) return true;
  const std::string_view port = std::string_view(address).substr(address.rfind(':') + 1);
  return parsed_between<std::uint16_t>(port, 1, std::numeric_limits<std::uint16_t>::max())
      .has_value();
}

AddressList::AddressList(const std::string& text) {
  std::istringstream list(text + ",");
  for (std::string address; std::getline(list, address, ',');) {
    if (address.empty() || std::ranges::find(addresses_, address) != addresses_.end()) {
      throw InputError("cannot connect to '" + text +
                       "': an address is empty or occurs twice: write a list like "
                       "tcp://127.0.0.1:7400,tcp://127.0.0.2:7400");
    }
    if (!has_port(address)) {
      throw InputError("cannot connect to '" + address +
                       "': the port must be a number from 1 to 65535: write an address like "
                       "tcp://127.0.0.1:7400");
    }
    addresses_.push_back(std::move(address));
  }
}

void AddressList::sent(Time now, std::size_t bytes) {
  constexpr std::size_t most_doublings = 4;
  if (give_up_at_ == never) {
    give_up_at_ = now + seconds(5) * (1U << std::min(silent_ / addresses_.size(), most_doublings));
  }
  constexpr std::size_t bytes_per_microsecond = 10;
  give_up_at_ += std::chrono::microseconds(bytes / bytes_per_microsecond);
}

void AddressList::heard() {
  give_up_at_ = never;
  silent_ = 0;
}

bool AddressList::move_on(Time now) {
  if (addresses_.size() == 1 || now < give_up_at_) return false;
  give_up_at_ = never;
  ++silent_;
  current_ = (current_ + 1) % addresses_.size();
  return true;
}

}  // namespace parray::proto
