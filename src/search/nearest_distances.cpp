#include "clothsim/search/nearest_distances.h"

#include <algorithm>
#include <cmath>

#include "clothsim/geometry/box_tree.h"
#include "clothsim/model/checks.h"

namespace clothsim {
namespace {

/// Pairs of tiles that are near each other at rest, by tile: a cell has some 60 of them where it is
/// four times as long as the contact distance. More take gigabytes.
constexpr std::size_t max_near_tiles = 1000;

/// Features of a mesh that are nearer than this at rest, of its mean edge, are one: a seam.
constexpr double seam = 1e-3;

/// [m]; 0 without edges.
double mean_edge(const SurfaceMesh& mesh, const Points& rest) {
  double sum = 0;
  for (const auto& [a, b] : mesh.edges) sum += (row(rest, a) - row(rest, b)).norm();
  return mesh.edges.empty() ? 0 : sum / static_cast<double>(mesh.edges.size());
}

/// Spacing along rows and along columns; with a single row or column both are that of the other.
Eigen::Vector2d spacing_of(const Cloth& cloth) {
  const auto to = [&](int point) -> double {
    return (row(cloth.rest_positions, point) - row(cloth.rest_positions, 0)).norm();
  };
  const int along = cloth.columns > 1 ? 1 : 0, up = cloth.rows > 1 ? cloth.columns : 0;
  return {to(along > 0 ? along : up), to(up > 0 ? up : along)};
}

/// Calls visit(p, q), p <= q, for patches that may be within the mean of both within(patch) of each
/// other at rest [m].
template <typename Within, typename Visit>
void visit_near_patches(const std::vector<Patch>& patches, const Points& rest, const Within& within,
                        const Visit& visit) {
  std::vector<Box> wider;
  for (int p = 0; p < static_cast<int>(patches.size()); ++p) {
    const Patch& patch = patches[static_cast<std::size_t>(p)];
    Box box = around(rest, patch.points);
    box.min().array() -= within(patch) / 2;
    box.max().array() += within(patch) / 2;
    wider.push_back(box);
    visit(p, p);
  }
  BoxTree(wider).visit_overlaps(visit);
}

/// Distance of two features at rest; below 0 where they share a point.
double distance_at_rest(const SurfacePair& pair, const Points& rest) {
  const auto& [a, b, c, d] = pair.points;
  const bool share = a == c || a == d || b == d || (pair.edges() ? b == c : a == b);
  return share ? -1 : separation(pair, rest).distance;
}

}  // namespace

/// `max`: where features are no neighbours [m]. `at_rest`: the distance of each pair; below 0 where
/// they share a point.
template <typename AtRest>
NearestDistances::Tiles NearestDistances::make_tiles(double max, const AtRest& at_rest) {
  Tiles tiles{max, {}};
  for (std::size_t k = 0; k < Tiling::count; ++k) {
    const double distance = at_rest(k);
    tiles.of[k] = distance < 0 ? -1 : std::min(max, neighbour_share * distance);
    if (k == Tiling::own_points) {
      tiles.of[k] = distance < apart_at_rest * max ? -1 : max;
    }
  }
  return tiles;
}

void NearestDistances::keep_places() {
  for (const Tiling::Tile& tile : tiling_->tiles()) {
    auto& [first, second] = places_.emplace_back();
    for (std::size_t k = 0; k < Tiling::count; ++k) {
      first[k] = tile.own[Tiling::of_a[k]];
      second[k] = tile.own[Tiling::of_b[k]];
    }
  }
}

/// Largest over the features that count.
float NearestDistances::max_distance(const Tiles& tiles) const {
  return static_cast<float>(
      *std::max_element(tiles.of.data() + stencils_.begin, tiles.of.data() + stencils_.end));
}

NearestDistances::NearestDistances(const Cloth& cloth, std::shared_ptr<const Tiling> tiling,
                                   const std::vector<Patch>& patches, const Tiling::Range& stencils)
    : tiling_(std::move(tiling)), stencils_(stencils), thickness_{cloth.thickness} {
  keep_places();
  const Eigen::Vector2d spacing = spacing_of(cloth);
  spacing_ = spacing.minCoeff();
  min_at_rest_ = spacing.prod() / spacing.norm();
  std::vector<Eigen::Vector2i> places, of_patches;
  for (int i = 0; i < cloth.num_points(); ++i) {
    places.emplace_back(i % cloth.columns, i / cloth.columns);
  }
  for (const Patch& patch : patches) {
    of_patches.push_back(places[static_cast<std::size_t>(patch.tiles[0])] / Patch::side);
  }
  // Tiles farther apart have the full contact distance, or do not exist.
  const Eigen::Vector2d last(cloth.columns - 1, cloth.rows - 1);
  const double far = std::ceil(max() / (neighbour_share * spacing_)) + 2;
  const Eigen::Vector2i max_offset = last.cwiseMin(far).cast<int>();
  const GridOffsets offsets(std::move(places), max_offset);
  for (const Eigen::Vector2i& offset : offsets.offsets()) {
    tiles_.push_back(make_tiles_of_grid(offset, spacing));
  }
  // Patches farther apart have no tiles within that.
  const GridOffsets patch_offsets(std::move(of_patches),
                                  max_offset / Patch::side + Eigen::Vector2i::Constant(2));
  for (const Eigen::Vector2i& offset : patch_offsets.offsets()) {
    auto& [values, numbers] = of_patches_.emplace_back();
    for (std::size_t k = 0; k < values.size(); ++k) {
      const auto i = static_cast<int>(k / TileShapes::tiles),
                 j = static_cast<int>(k % TileShapes::tiles);
      const Eigen::Vector2i from(i % Patch::side, i / Patch::side),
          to(j % Patch::side, j / Patch::side);
      numbers[k] = offsets.number_of(Patch::side * offset + to - from);
      values[k] = max_distance(tiles_[static_cast<std::size_t>(numbers[k])]);
    }
  }
  tile_offsets_ = offsets;
  patch_offsets_ = patch_offsets;
}

/// Both tiles in rows of two points.
NearestDistances::Tiles NearestDistances::make_tiles_of_grid(const Eigen::Vector2i& offset,
                                                             const Eigen::Vector2d& spacing) const {
  const Tiling cells(2, 4);
  Points corners = Points::Zero(8, 3);
  for (int i = 0; i < corners.rows(); ++i) {
    Eigen::Vector2i place(i % 2, i / 2 % 2);
    if (i >= 4) place += offset;
    corners.block<1, 2>(i, 0) = place.cast<double>().cwiseProduct(spacing).transpose();
  }
  return make_tiles(max(), [&](std::size_t k) {
    const double distance = separation(cells.pair(0, 4, k), corners).distance;
    return distance < min_at_rest_ / 2 ? -1 : distance;  // they share a point
  });
}

NearestDistances::NearestDistances(const SurfaceMesh& mesh, const Points& rest,
                                   std::vector<double> thickness,
                                   std::shared_ptr<const Tiling> tiling,
                                   const std::vector<Patch>& patches, const Tiling::Range& stencils)
    : tiling_(std::move(tiling)), stencils_(stencils), thickness_(std::move(thickness)) {
  keep_places();
  spacing_ = mean_edge(mesh, rest);
  if (spacing_ == 0) spacing_ = max();
  min_at_rest_ = spacing_;
  for (const double a : thickness_) {
    for (const double b : thickness_) {
      tiles_.push_back(make_tiles(a + b, [](std::size_t) { return infinity; }));
    }
  }
  for (const auto& tile : tiling_->tiles()) {
    cloths_.push_back(static_cast<std::size_t>(mesh.cloth_of(tile.points[0])));
  }
  OfPatches far_patches{};
  far_patches.max.fill(static_cast<float>(max()));
  far_patches.numbers.fill(NearOffsets::far);
  of_patches_.push_back(far_patches);
  NearOffsets tile_offsets(tiling_->tiles().size()), patch_offsets(patches.size());
  const auto within = [&](const Patch& patch) { return neighbours_within(patch); };
  visit_near_patches(patches, rest, within, [&](int p, int q) {
    const auto &of_p = patches[static_cast<std::size_t>(p)].tiles,
               &of_q = patches[static_cast<std::size_t>(q)].tiles;
    patch_offsets.add(p, q, static_cast<int>(of_patches_.size()));
    auto& [values, numbers] = of_patches_.emplace_back(far_patches);
    for (std::size_t k = 0; k < values.size(); ++k) {
      const int a = of_p[k / TileShapes::tiles], b = of_q[k % TileShapes::tiles];
      if (a == Patch::none || b == Patch::none) continue;
      add_neighbours(a, b, rest, tile_offsets);
      if (p != q) add_neighbours(b, a, rest, tile_offsets);
      numbers[k] = tile_offsets.number(a, b);
      values[k] = max_distance(tiles(static_cast<std::size_t>(numbers[k]), a, b));
    }
  });
  tile_offsets_ = std::move(tile_offsets);
  patch_offsets_ = std::move(patch_offsets);
}

/// Adds two tiles of one cloth unless they are far apart at rest.
void NearestDistances::add_neighbours(int a, int b, const Points& rest, NearOffsets& offsets) {
  const std::size_t cloth = cloths_[static_cast<std::size_t>(a)];
  if (cloth != cloths_[static_cast<std::size_t>(b)]) return;
  const Tiles both = make_tiles_of_mesh(2 * thickness_[cloth], a, b, rest);
  if (both.of == tiles_[far_number(a, b)].of) return;
  offsets.add(a, b, static_cast<int>(tiles_.size()));
  tiles_.push_back(both);
  const std::size_t near = tiles_.size() - thickness_.size() * thickness_.size();
  if (near < max_near_tiles * std::max<std::size_t>(tiling_->tiles().size(), 64)) return;
  throw InvalidValue({"thickness"}, to_text(thickness_[cloth]),
                     "less beside the mesh's edges of some " + to_text(spacing_) + " m");
}

double NearestDistances::neighbours_within(const Patch& patch) const {
  double thickest = 0;
  for (const int tile : patch.tiles) {
    if (tile == Patch::none) continue;
    thickest = std::max(thickest, thickness_[cloths_[static_cast<std::size_t>(tile)]]);
  }
  return 2 * thickest / neighbour_share;
}

NearestDistances::Tiles NearestDistances::make_tiles_of_mesh(double max, int a, int b,
                                                             const Points& rest) {
  return make_tiles(max, [&](std::size_t k) {
    if (place(a, b, k) == Tiling::lacking) return infinity;
    const double distance = distance_at_rest(tiling_->pair(a, b, k), rest);
    if (distance < seam * spacing_) return -1.0;
    min_at_rest_ = std::min(min_at_rest_, distance);
    return distance;
  });
}

double NearestDistances::of_tracked(int point, int triangle) const {
  const int a = tiling_->of_point(point), b = tiling_->of_triangle(triangle);
  return of(a, b, triangle == tiling_->at(b).triangles[0] ? 0 : 1);
}

NearestDistances::OfTiles NearestDistances::of_tiles(const OfPatches& patches, int number, int a,
                                                     int b) const {
  const auto pair = static_cast<std::size_t>(number);
  const Tiles& both = tiles(static_cast<std::size_t>(patches.numbers[pair]), a, b);
  // By FeaturePlace: tables, as a compiler would branch, and places are hard to predict.
  std::array<double, 3> of_edges, of_others;
  for (const auto at : {Tiling::inside, Tiling::border, Tiling::lacking}) {
    of_edges[at] = max_distance(both.max, at, Tiling::points);
    of_others[at] = max_distance(both.max, at, 0);
  }
  OfTiles of;
  for (std::size_t k = 0; k < Tiling::count; ++k) {
    const auto& max_distances = Tiling::is_of_edges(k) ? of_edges : of_others;
    of[k] = static_cast<float>(std::min(both.of[k], max_distances[place(a, b, k)]));
  }
  return of;
}

}  // namespace clothsim
