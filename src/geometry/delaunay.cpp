#include "clothsim/geometry/delaunay.h"

#include <boost/polygon/voronoi.hpp>
#include <cmath>
#include <cstdint>

namespace clothsim {
namespace {

/// Whole numbers that places become: Boost's diagram takes 32 bits.
constexpr double largest = 1e9;

}  // namespace

std::vector<std::array<int, 3>> delaunay_triangles(const std::vector<Eigen::Vector2d>& points) {
  if (points.size() < 3) return {};
  Eigen::Vector2d low = points.front(), high = low;
  for (const Eigen::Vector2d& p : points) {
    low = low.cwiseMin(p);
    high = high.cwiseMax(p);
  }
  const double scale = largest / (high - low).maxCoeff();
  std::vector<boost::polygon::point_data<std::int32_t>> sites;
  sites.reserve(points.size());
  for (const Eigen::Vector2d& p : points) {
    const Eigen::Vector2d at = scale * (p - low);
    sites.emplace_back(static_cast<std::int32_t>(std::lround(at.x())),
                       static_cast<std::int32_t>(std::lround(at.y())));
  }
  boost::polygon::voronoi_diagram<double> diagram;
  boost::polygon::construct_voronoi(sites.begin(), sites.end(), &diagram);

  std::vector<std::array<int, 3>> triangles;
  for (const auto& vertex : diagram.vertices()) {
    std::vector<int> around;  // the points whose cells meet in the vertex
    const auto* edge = vertex.incident_edge();
    do {
      around.push_back(static_cast<int>(edge->cell()->source_index()));
      edge = edge->rot_next();
    } while (edge != vertex.incident_edge());
    for (std::size_t i = 2; i < around.size(); ++i) {
      triangles.push_back({around[0], around[i - 1], around[i]});
    }
  }
  return triangles;
}

}  // namespace clothsim
