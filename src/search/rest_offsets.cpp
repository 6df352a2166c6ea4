#include "clothsim/search/rest_offsets.h"

#include <algorithm>

namespace clothsim {

void NearOffsets::add(int from, int to, int number) {
  auto& near = near_[static_cast<std::size_t>(from)];
  const std::pair<int, int> entry(to, number);
  near.insert(std::lower_bound(near.begin(), near.end(), entry), entry);
}

int NearOffsets::number(int from, int to) const {
  const auto& near = near_[static_cast<std::size_t>(from)];
  const auto found = std::lower_bound(near.begin(), near.end(), std::pair(to, 0));
  return found != near.end() && found->first == to ? found->second : far;
}

}  // namespace clothsim
