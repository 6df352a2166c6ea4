#include "clothsim/search/tracked_pairs.h"

#include <algorithm>
#include <cmath>
#include <memory>
#include <stdexcept>
#include <vector>

#include "clothsim/search/patches.h"
#include "verification/testing.h"

namespace clothsim::tracked_pairs_test {
namespace {

/// A point of a cloth that is thicker than its cells, and two triangles with an edge in common.
/// `near` is the nearer neighbour on the cloth, so that the point may come nearer to it.
class SurfaceSlotsOfNeighbours : public ::testing::Test {
 protected:
  SurfaceSlotsOfNeighbours() {
    ClothSpec spec;
    spec.columns = 4;
    spec.rows = 16;
    spec.width = 0.03;
    spec.height = 0.15;
    spec.thickness = 0.0095;
    cloth_ = make_grid(spec);
    mesh_ = std::make_shared<SurfaceMesh>(cloth_);
    const auto tiling = std::make_shared<Tiling>(cloth_.columns, cloth_.rows);
    const auto patches = cut_into_patches(*tiling, cloth_.columns, cloth_.rows);
    nearest_ = std::make_shared<NearestDistances>(cloth_, tiling, patches, Tiling::of_surfaces);
    for (near_ = 0; near_ < static_cast<int>(mesh_->triangles.size()); ++near_) {
      for (far_ = 0; far_ < static_cast<int>(mesh_->triangles.size()); ++far_) {
        edge_.clear();
        for (const int i : corners(near_)) {
          if (has(far_, i)) edge_.push_back(i);
        }
        const double to_near = nearest_->of_tracked(point, near_);
        if (edge_.size() == 2 && to_near > 0 &&
            nearest_->of_tracked(point, far_) > 1.02 * to_near) {
          return;
        }
      }
    }
    throw std::logic_error("the cloth has no such triangles");
  }

  const std::array<int, 3>& corners(int triangle) const {
    return mesh_->triangles[static_cast<std::size_t>(triangle)];
  }
  bool has(int triangle, int i) const {
    return std::count(corners(triangle).begin(), corners(triangle).end(), i) > 0;
  }
  int tip_of(int triangle) const {
    return *std::find_if(corners(triangle).begin(), corners(triangle).end(), [&](int i) {
      return std::find(edge_.begin(), edge_.end(), i) == edge_.end();
    });
  }

  /// The point is at the origin, the edge `apart` [m] above it. The edge is the nearest place of
  /// the far triangle. From there the near triangle goes on to a place at `to_near` from the point,
  /// or rises where `to_near` is not smaller. All else is far away.
  Points place(double apart, double to_near) const {
    Points x = Points::Constant(cloth_.num_points(), 3, 9);
    x.row(point) << 0, 0, 0;
    x.row(edge_[0]) << 0, -0.02, apart;
    x.row(edge_[1]) << 0, 0.02, apart;
    x.row(tip_of(far_)) << -0.01, 0, apart + 0.01;
    x.row(tip_of(near_)) << 0.01, 0, apart + 0.01;
    if (to_near < apart) {
      const double slope = std::acos(to_near / apart), way = 2 * apart * std::sin(slope);
      x.row(tip_of(near_)) << way * std::cos(slope), 0, apart - way * std::sin(slope);
    }
    return x;
  }

  /// Place of a slot of the far triangle, after the cloth has moved to that state.
  int track(double apart, double to_near) const {
    TrackedPairs slots(mesh_, nearest_);
    const double at_first = 1.2 * nearest_->of_tracked(point, far_);
    const auto& [a, b, c] = corners(far_);
    slots.add({{far_, {point, a, b, c}, nearest_->of_tracked(point, far_)}},
              place(at_first, at_first));
    EXPECT_EQ(slots.of(point).front().pair.triangle, far_);
    slots.track(place(apart, to_near));
    return slots.of(point).front().pair.triangle;
  }

  static constexpr int point = 1;
  Cloth cloth_;
  std::shared_ptr<SurfaceMesh> mesh_;
  std::shared_ptr<NearestDistances> nearest_;
  int near_, far_;
  std::vector<int> edge_;
};

TEST_F(SurfaceSlotsOfNeighbours, StayWhereTheyTouch) {
  // At the other triangle the gap is smaller, but that would let the point come nearer to this one.
  const double may_far = nearest_->of_tracked(point, far_),
               may_near = nearest_->of_tracked(point, near_);
  EXPECT_EQ(track(0.999 * may_far, 0.99 * may_near), far_);
  EXPECT_EQ(track(may_far + 0.9 * (may_far - may_near), 0.99 * may_near), far_);
}

TEST_F(SurfaceSlotsOfNeighbours, GoOnFromWhereTheyDoNot) {
  const double may_far = nearest_->of_tracked(point, far_),
               may_near = nearest_->of_tracked(point, near_);
  EXPECT_EQ(track(may_far + 1.1 * (may_far - may_near), may_near), near_);
}

}  // namespace
}  // namespace clothsim::tracked_pairs_test
