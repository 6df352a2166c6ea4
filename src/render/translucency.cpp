#include "clothsim/render/translucency.h"

#include <algorithm>
#include <utility>

#include "clothsim/render/image_tiles.h"

namespace clothsim {
namespace {

/// Drivers round corners to a part of a pixel, and samples lie within half a pixel of its centre.
constexpr double margin = 1;  // [pixel]

/// Bounds the tiles that each of many long triangles covers.
constexpr std::size_t most_tiles = 1 << 14;

/// A triangle in the image.
struct DrawnTriangle {
  double depth;  // of its centroid [m]
  int item;
  int number;
  int run = 0;
  ImageTiles::Block tiles;
};

/// Vertices of an item as they are drawn, in the optical frame [m].
Points drawn_vertices(const DrawItem& item, const Camera& camera) {
  const double scale = item.sphere_radius ? 1 - item.dip / *item.sphere_radius : 1;
  const Eigen::Matrix3d to_optical =
      camera.pose.orientation.normalized().toRotationMatrix().transpose();
  const auto& [first, count] = item.own_points;
  return (scale * item.positions->middleRows(first, count) *
          (to_optical * item.rotation).transpose())
             .rowwise() +
         (to_optical * item.translation).transpose();
}

std::vector<DrawnTriangle> drawn_triangles(const std::vector<const DrawItem*>& items,
                                           const Camera& camera, const ImageTiles& tiles,
                                           std::size_t most) {
  std::vector<DrawnTriangle> triangles;
  triangles.reserve(most);
  for (std::size_t i = 0; i < items.size(); ++i) {
    const DrawItem& item = *items[i];
    const Points vertices = drawn_vertices(item, camera);
    const auto& [first, count] = item.own_triangles;
    for (int number = first; number < first + count; ++number) {
      const auto& corners = (*item.triangles)[static_cast<std::size_t>(number)];
      std::array<Vector3, 3> corner;
      for (std::size_t k = 0; k < 3; ++k)
        corner[k] = vertices.row(corners[k] - item.own_points.first);
      const double depth = (corner[0].z() + corner[1].z() + corner[2].z()) / 3;
      Eigen::AlignedBox2d seen = seen_box(camera, corner);
      if (seen.isEmpty()) continue;
      seen.min().array() -= margin;
      seen.max().array() += margin;
      const ImageTiles::Block covered = tiles.covered(seen);
      if (!covered.empty()) triangles.push_back({depth, static_cast<int>(i), number, 0, covered});
    }
  }
  return triangles;
}

/// Numbers of the triangles, farthest first.
std::vector<std::size_t> sort_by_depth(const std::vector<DrawnTriangle>& triangles) {
  std::vector<std::pair<double, std::size_t>> keys;
  keys.reserve(triangles.size());
  for (std::size_t k = 0; k < triangles.size(); ++k) keys.push_back({-triangles[k].depth, k});
  std::sort(keys.begin(), keys.end());
  std::vector<std::size_t> order;
  order.reserve(keys.size());
  for (const auto& key : keys) order.push_back(key.second);
  return order;
}

/// Assigns each triangle to a run, in order of depth: the run of triangles before it in a common
/// tile, or a later one. Run r has triangles of item r % num_items. Returns the number of runs.
int find_runs(const std::vector<std::size_t>& order, int num_items, const ImageTiles& tiles,
              std::vector<DrawnTriangle>& triangles) {
  std::vector<int> last_run(static_cast<std::size_t>(tiles.num_tiles()), 0);
  int last = 0;
  for (const std::size_t k : order) {
    DrawnTriangle& triangle = triangles[k];
    int run = 0;
    tiles.for_each(triangle.tiles, [&](int tile) {
      run = std::max(run, last_run[static_cast<std::size_t>(tile)]);
    });
    run += (triangle.item - run % num_items + num_items) % num_items;
    tiles.for_each(triangle.tiles,
                   [&](int tile) { last_run[static_cast<std::size_t>(tile)] = run; });
    triangle.run = run;
    last = std::max(last, run);
  }
  return last + 1;
}

}  // namespace

BackToFront sort_back_to_front(const std::vector<const DrawItem*>& items, const Camera& camera) {
  std::size_t count = 0;
  for (const DrawItem* item : items) count += static_cast<std::size_t>(item->own_triangles.count);
  const ImageTiles tiles(camera, std::min(count, most_tiles));
  std::vector<DrawnTriangle> triangles = drawn_triangles(items, camera, tiles, count);
  const std::vector<std::size_t> order = sort_by_depth(triangles);
  const int num_runs = find_runs(order, static_cast<int>(items.size()), tiles, triangles);

  BackToFront sorted;
  std::vector<int> places(static_cast<std::size_t>(num_runs), 0);  // the next one of each run
  for (const DrawnTriangle& t : triangles) ++places[static_cast<std::size_t>(t.run)];
  int first = 0;
  for (std::size_t run = 0; run < places.size(); ++run) {
    const int run_count = std::exchange(places[run], first);
    if (run_count > 0) sorted.runs.push_back({items[run % items.size()], first, run_count});
    first += run_count;
  }
  sorted.triangles.resize(triangles.size());
  for (const std::size_t k : order) {
    const DrawnTriangle& t = triangles[k];
    const int place = places[static_cast<std::size_t>(t.run)]++;
    sorted.triangles[static_cast<std::size_t>(place)] =
        (*items[static_cast<std::size_t>(t.item)]->triangles)[static_cast<std::size_t>(t.number)];
  }
  return sorted;
}

}  // namespace clothsim
