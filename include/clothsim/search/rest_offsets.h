#pragma once

#include <utility>
#include <vector>

#include "clothsim/model/types.h"

namespace clothsim {

/// Numbers for the relative place of two items of a grid at rest: by the offset from one to the
/// other, along columns and rows. Beyond `max_offset` the number is that at it.
class GridOffsets {
 public:
  /// `places`: column and row of each.
  GridOffsets(std::vector<Eigen::Vector2i> places, const Eigen::Vector2i& max_offset)
      : places_(std::move(places)), max_offset_(max_offset) {}

  int number(int from, int to) const { return number_of(offset(from, to)); }
  int number_of(const Eigen::Vector2i& offset) const {
    const Eigen::Vector2i place = offset.cwiseMax(-max_offset_).cwiseMin(max_offset_) + max_offset_;
    return place.y() * (2 * max_offset_.x() + 1) + place.x();
  }
  Eigen::Vector2i offset(int from, int to) const {
    return places_[static_cast<std::size_t>(to)] - places_[static_cast<std::size_t>(from)];
  }

  /// All offsets that have a number, in its order.
  std::vector<Eigen::Vector2i> offsets() const {
    std::vector<Eigen::Vector2i> all;
    for (int row = -max_offset_.y(); row <= max_offset_.y(); ++row) {
      for (int column = -max_offset_.x(); column <= max_offset_.x(); ++column) {
        all.emplace_back(column, row);
      }
    }
    return all;
  }

 private:
  std::vector<Eigen::Vector2i> places_;
  Eigen::Vector2i max_offset_;
};

/// The same for any surface: near items have numbers of their own, all others `far`.
class NearOffsets {
 public:
  enum { far = 0 };

  explicit NearOffsets(std::size_t things = 0) : near_(things) {}

  /// Numbers ascend from far + 1 on.
  void add(int from, int to, int number);
  int number(int from, int to) const;

 private:
  std::vector<std::vector<std::pair<int, int>>> near_;  // by `from`: `to` and number, ascending
};

}  // namespace clothsim
