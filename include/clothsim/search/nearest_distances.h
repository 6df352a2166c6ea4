#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <memory>
#include <variant>
#include <vector>

#include "clothsim/geometry/surface_pair.h"
#include "clothsim/model/cloth.h"
#include "clothsim/search/patches.h"
#include "clothsim/search/rest_offsets.h"
#include "clothsim/search/tiles.h"

namespace clothsim {

/// Contact distance of two features: the sum of the thickness of both cloths, or for neighbours on
/// one cloth a quarter of their distance at rest, so that it can fold sharply without passing
/// through itself. Different cloths have no neighbours.
///
/// Two edges inside the cloth have a share of that. Where layers lie on each other, points keep
/// them that far apart, and contacts of edges would be redundant; they remain where folds
/// cross whose points miss each other. An edge of the border has no cloth beside it with points for
/// contact: it keeps the whole distance.
///
/// Points alone: neighbours, with a rest distance below twice that of contact, are left out. A fold
/// between them has no room for a layer.
///
/// A grid looks the same from every cell, so distances are stored by the offset between tiles. On
/// any other surface they are stored for each pair of tiles that are near each other at rest.
class NearestDistances {
 public:
  /// Contact distance of neighbours on the cloth, of their distance at rest.
  static constexpr double neighbour_share = 0.25;
  /// Contact distance of edges inside the cloth, of that of points: with all of it two thirds of
  /// the contacts of a pile are of edges, with this a tenth, and it comes to rest sooner.
  static constexpr double edge_share = 0.8;
  /// Rest distance from which points are no neighbours, of the contact distance.
  static constexpr double apart_at_rest = 2;

  /// For a surface in tiles and patches at `rest` [m, N x 3]. `thickness`: by cloth [m].
  /// `stencils`: the pairs of features that count.
  NearestDistances(const SurfaceMesh&, const Points& rest, std::vector<double> thickness,
                   std::shared_ptr<const Tiling>, const std::vector<Patch>&,
                   const Tiling::Range& stencils);
  /// For a grid.
  NearestDistances(const Cloth&, std::shared_ptr<const Tiling>, const std::vector<Patch>&,
                   const Tiling::Range& stencils);

  /// For pair `number` of the features of tiles a and b [m]: below 0 where these share a point, or
  /// one of them does not exist.
  double of(int a, int b, std::size_t number) const {
    const Tiles& both = tiles(a, b);
    return std::min(both.of[number], max_distance(both.max, place(a, b, number), number));
  }
  /// For a point and a triangle [m].
  double of_tracked(int point, int triangle) const;
  /// Distances between the tiles of two patches p <= q, by pair of tiles as in TileShapes::Near:
  /// at least the largest, over the features that count [m], and numbers for of_tiles().
  struct OfPatches {
    TileShapes::PairValues max;
    std::array<int, TileShapes::tiles * TileShapes::tiles> numbers;
  };
  const OfPatches& of_patches(int p, int q) const {
    return of_patches_[number(patch_offsets_, p, q)];
  }
  /// For all features of tiles a and b, pair `number` of two patches.
  using OfTiles = std::array<float, Tiling::count>;
  OfTiles of_tiles(const OfPatches& patches, int number, int a, int b) const;
  bool at_border(int tile) const {
    return tiling_->at(tile).own[Tiling::own_point] == Tiling::border;
  }

  /// The largest and the least for features that count, and the least distance at rest of features
  /// that share no point: on a grid that of a point and the long side of a triangle, as of two
  /// diagonals side by side [m].
  double max() const { return 2 * *std::max_element(thickness_.begin(), thickness_.end()); }
  double min() const {
    const double thinnest = 2 * *std::min_element(thickness_.begin(), thickness_.end());
    if (stencils_.are_points()) return thinnest;
    return std::min(edge_share * thinnest, neighbour_share * min_at_rest_);
  }
  double min_at_rest() const { return min_at_rest_; }

  /// Distance of points that share an edge: the least on a grid, else the mean [m].
  double spacing() const { return spacing_; }

 private:
  using Offsets = std::variant<NearOffsets, GridOffsets>;
  /// For two tiles, as if at the border.
  struct Tiles {
    double max;  // where they are no neighbours [m]
    std::array<double, Tiling::count> of;
  };
  /// A tile's features in each pair of features, as those of the first tile and of the second.
  using Places = std::array<Tiling::FeaturePlace, Tiling::count>;

  static std::size_t number(const Offsets& offsets, int from, int to) {
    return static_cast<std::size_t>(
        std::visit([&](const auto& of) { return of.number(from, to); }, offsets));
  }
  const Tiles& tiles(int a, int b) const { return tiles(number(tile_offsets_, a, b), a, b); }
  const Tiles& tiles(std::size_t own, int a, int b) const {
    return tiles_[own != NearOffsets::far || cloths_.empty() ? own : far_number(a, b)];
  }
  /// Number of tiles that are no neighbours, by the cloths that they are of.
  std::size_t far_number(int a, int b) const {
    return thickness_.size() * cloths_[static_cast<std::size_t>(a)] +
           cloths_[static_cast<std::size_t>(b)];
  }
  Tiling::FeaturePlace place(int a, int b, std::size_t number) const {
    return std::max(places_[static_cast<std::size_t>(a)][0][number],
                    places_[static_cast<std::size_t>(b)][1][number]);
  }
  /// Sets `places_`.
  void keep_places();
  /// Contact distance of features that are no neighbours, where points have `max` [m].
  static double max_distance(double max, Tiling::FeaturePlace place, std::size_t number) {
    if (place == Tiling::lacking) return -1;
    return Tiling::is_of_edges(number) && place == Tiling::inside ? edge_share * max : max;
  }
  template <typename AtRest>
  static Tiles make_tiles(double max, const AtRest&);
  /// Distance at rest beyond which tiles of one cloth are no neighbours [m].
  double neighbours_within(const Patch&) const;
  void add_neighbours(int a, int b, const Points& rest, NearOffsets&);
  Tiles make_tiles_of_mesh(double max, int a, int b, const Points& rest);
  Tiles make_tiles_of_grid(const Eigen::Vector2i& offset, const Eigen::Vector2d& spacing) const;
  float max_distance(const Tiles&) const;

  std::shared_ptr<const Tiling> tiling_;
  Tiling::Range stencils_;
  std::vector<double> thickness_;              // by cloth [m]
  std::vector<std::size_t> cloths_;            // of tiles; empty: one
  std::vector<std::array<Places, 2>> places_;  // by tile
  double spacing_;
  double min_at_rest_;
  Offsets tile_offsets_, patch_offsets_;
  std::vector<Tiles> tiles_;  // of a mesh: first by far_number()
  std::vector<OfPatches> of_patches_;
};

}  // namespace clothsim
