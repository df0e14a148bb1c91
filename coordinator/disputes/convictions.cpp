#include "coordinator/disputes/convictions.h"

#include <algorithm>
#include <nlohmann/json.hpp>
#include <utility>

namespace parray::coordinator {

using nlohmann::json;

Conviction Convictions::add(std::uint64_t machine, std::string worker) {
  const std::uint64_t number = latest() + 1;
  std::erase_if(list_, [machine](const Conviction& c) { return c.machine == machine; });
  if (list_.size() == most) {
    list_.erase(list_.begin());
  }
  return list_.emplace_back(number, machine, std::move(worker));
}

std::vector<Conviction> Convictions::after(std::uint64_t number) const {
  return {std::ranges::upper_bound(list_, number, {}, &Conviction::number), list_.end()};
}

json Convictions::to_json() const {
  json list = json::array();
  for (const Conviction& conviction : list_) {
    list.push_back({{"number", conviction.number},
                    {"machine", conviction.machine},
                    {"worker", conviction.worker}});
  }
  return list;
}

Convictions Convictions::from_json(const json& list) {
  Convictions convictions;
  for (const json& entry : list) {
    convictions.list_.push_back({entry.at("number").get<std::uint64_t>(),
                                 entry.at("machine").get<std::uint64_t>(),
                                 entry.at("worker").get<std::string>()});
  }
  std::ranges::sort(convictions.list_, {}, &Conviction::number);
  return convictions;
}

}  // namespace parray::coordinator
