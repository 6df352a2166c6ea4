#include "clothsim/search/rest_ways.h"

#include <algorithm>

namespace clothsim {

void NearWays::add(int from, int to, int number) {
  auto& near = near_[static_cast<std::size_t>(from)];
  const std::pair<int, int> entry(to, number);
  near.insert(std::lower_bound(near.begin(), near.end(), entry), entry);
}

int NearWays::number(int from, int to) const {
  const auto& near = near_[static_cast<std::size_t>(from)];
  const auto found = std::lower_bound(near.begin(), near.end(), std::pair(to, 0));
  return found != near.end() && found->first == to ? found->second : far;
}

}  // namespace clothsim
