#pragma once

#include <utility>
#include <vector>

#include "clothsim/model/types.h"

namespace clothsim {

/// Numbers for the relative place of two items of a grid at rest: by the offset from one to the
/// other, along columns and rows. Beyond `max_way` the number is that at it.
class GridWays {
 public:
  /// `places`: column and row of each.
  GridWays(std::vector<Eigen::Vector2i> places, const Eigen::Vector2i& max_way)
      : places_(std::move(places)), max_way_(max_way) {}

  int number(int from, int to) const { return number_of(way(from, to)); }
  int number_of(const Eigen::Vector2i& way) const {
    const Eigen::Vector2i place = way.cwiseMax(-max_way_).cwiseMin(max_way_) + max_way_;
    return place.y() * (2 * max_way_.x() + 1) + place.x();
  }
  Eigen::Vector2i way(int from, int to) const {
    return places_[static_cast<std::size_t>(to)] - places_[static_cast<std::size_t>(from)];
  }

  /// All offsets that have a number, in its order.
  std::vector<Eigen::Vector2i> ways() const {
    std::vector<Eigen::Vector2i> all;
    for (int row = -max_way_.y(); row <= max_way_.y(); ++row) {
      for (int column = -max_way_.x(); column <= max_way_.x(); ++column) {
        all.emplace_back(column, row);
      }
    }
    return all;
  }

 private:
  std::vector<Eigen::Vector2i> places_;
  Eigen::Vector2i max_way_;
};

/// The same for any surface: near items have numbers of their own, all others `far`.
class NearWays {
 public:
  enum { far = 0 };

  explicit NearWays(std::size_t things = 0) : near_(things) {}

  /// Numbers ascend from far + 1 on.
  void add(int from, int to, int number);
  int number(int from, int to) const;

 private:
  std::vector<std::vector<std::pair<int, int>>> near_;  // by `from`: `to` and number, ascending
};

}  // namespace clothsim
