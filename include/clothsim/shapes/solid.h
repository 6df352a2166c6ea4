#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>
#include <vector>

#include "clothsim/geometry/intersections.h"
#include "clothsim/geometry/nearest_tree.h"
#include "clothsim/geometry/rays.h"
#include "clothsim/model/types.h"

namespace clothsim {

/// Triangles as in a file.
struct TriangleSoup {
  std::vector<Vector3> vertices;              // [m]
  std::vector<std::array<int, 3>> triangles;  // of vertices
};

/// The volume within closed triangles, summed triangle by triangle.
struct Volume {
  double sum = 0;    // below 0 where the surface is inside out [m^3]
  double parts = 0;  // sum of the triangles' absolute contributions [m^3]

  /// Adds a triangle, by its corners relative to an origin that is the same for all.
  void add(const Vector3& a, const Vector3& b, const Vector3& c);
  /// Is the volume zero but for rounding?
  bool is_none() const;
};

/// Triangles bound a solid within them, or a sheet that is open to both sides.
enum class Bounds { solid, sheet };

/// A solid within a closed surface of triangles, or the surface alone. Distances are exact, up to
/// rounding. Distances from a sheet are never negative.
///
/// A grid of cells lists, for each cell near the surface, the triangles that can be nearest to a
/// point in it, nearest first; elsewhere a tree of boxes finds the nearest. Outside, the grid also
/// stores a lower bound on the number of cells to the surface. Inside and outside are told apart by
/// the normals of faces, edges and vertices, the latter two weighted by angles (Baerentzen & Aanaes
/// 2005, "Signed distance computation using the angle weighted pseudonormal").
class Solid {
 public:
  /// An edge at which the surface bends outwards (a sheet: to either side, or where it ends), with
  /// the normals of the edge and of its ends: sums of the normals of the faces there, of any
  /// length.
  struct Ridge {
    std::array<Vector3, 2> ends;  // [m]
    Vector3 normal;
    std::array<Vector3, 2> end_normals;
    double angle;  // between its two faces' normals [rad]
  };

  /// Factor on a distance beyond which another one is larger, not only rounded up.
  static constexpr double beyond_rounding = 1 + 1e-6;

  /// Vertices at one place become one. Throws InvalidValue, without a key, unless the surface is
  /// finite, closed and of one sense, each edge between two triangles, with a volume inside. A
  /// surface that is inside out is turned. A sheet need only be finite.
  explicit Solid(const TriangleSoup&, Bounds = Bounds::solid);

  bool is_sheet() const { return is_sheet_; }

  /// Signed distance from the surface and the unit normal into free space; for a sheet, away from
  /// it. Where several points of the surface are nearest, the normal is that of one of them.
  std::pair<double, Vector3> distance(const Vector3& point) const;

  /// The triangles nearest to a place: a start for the search from places near it.
  struct Neighbourhood {
    static constexpr std::size_t most = 4;

    Vector3 place = Vector3::Zero();
    double outside = 0;  // distance of the place from the solid, 0 inside [m]
    double beyond = 0;   // lower bound on the distance of all other triangles [m]
    std::size_t count = 0;
    std::array<int, most> faces{};
    std::array<double, most> distances{};  // of these [m]

    // The last result of distance(), as the triangles that meet at a point ask for it one by one.
    Vector3 point = Vector3::Constant(NAN);
    std::pair<double, Vector3> distance{0, Vector3::UnitZ()};
  };

  /// distance() with the same bits for any `neighbourhood` of earlier points.
  std::pair<double, Vector3> distance(const Vector3& point, Neighbourhood& neighbourhood) const {
    if (point != neighbourhood.point) {
      neighbourhood.distance = distance_within(infinity, point, neighbourhood);
      neighbourhood.point = point;
    }
    return neighbourhood.distance;
  }

  /// distance() up to `near` [m], with the same bits for any `neighbourhood` of earlier points.
  /// Beyond `near` outside, the value lies between `near` and the distance, and the normal is
  /// arbitrary.
  std::pair<double, Vector3> distance_within(double near, const Vector3& point,
                                             Neighbourhood& neighbourhood) const;

  /// The ridges and faces near a triangle: a start for queries about it at places near by.
  struct Surroundings {
    std::array<Vector3, 3> place{};  // of the triangle
    double ridges_within = -1;  // lower bound on the distance of ridges that are not listed [m]
    double faces_within = -1;   // the same of faces
    std::vector<std::pair<double, int>> ridges;  // their distances from it, at least [m]; ascending
    std::vector<int> faces;                      // ascending

    /// Do they list all faces that a triangle meets, and all ridges within `reach` [m] of it?
    bool cover(const std::array<Vector3, 3>& t, double reach) const;
  };

  /// Makes surroundings cover a triangle with `reach`, and also once its corners have moved by up
  /// to half of `reach`.
  void look_around(const std::array<Vector3, 3>& t, double reach, Surroundings&) const;

  /// Is any ridge within `reach` [m] of a triangle? `surroundings`: of an earlier place, or null;
  /// they save the search.
  bool is_ridge_within(const std::array<Vector3, 3>& t, double reach, Surroundings*) const;

  /// Calls visit(i, ridge) for the ridges that may be within `most` [m] of a triangle; `visit` may
  /// lower `most`. `surroundings`: those that cover it with `most`, or null to search all. The
  /// nearer ones come first, by and large.
  template <class Visit>
  void visit_ridges(const std::array<Vector3, 3>& t, const Surroundings* surroundings, double& most,
                    const Visit& visit) const {
    if (surroundings && surroundings->ridges.empty()) return;
    // Rounding must not hide a ridge that is as near as another one.
    const auto square = [](double m) { return beyond_rounding * m * std::abs(m); };
    const TriangleBound bound(t);
    double most2 = square(most);
    const auto look = [&](int i) {
      const Ridge& ridge = ridges_[static_cast<std::size_t>(i)];
      if (bound.of(ridge.ends) > most2) return;
      visit(i, ridge);
      most2 = square(most);
    };
    if (surroundings) {
      const double moved = longest_displacement(surroundings->place, t);
      for (const auto& [least, i] : surroundings->ridges) {
        if (least - moved > beyond_rounding * most) break;
        look(i);
      }
    } else {
      ridge_tree_.search(bound, most2, look);
    }
  }

  /// Calls visit(i, place, face, normal) where the edge of a triangle from corner i on passes
  /// through a face with that unit normal. `surroundings`: those that cover it, or null to search
  /// all.
  template <class Visit>
  void visit_hits(const std::array<Vector3, 3>& t, const Surroundings* surroundings,
                  const Visit& visit) const {
    if (surroundings && surroundings->faces.empty()) return;
    const TriangleBound bound(t);
    const auto look = [&](int face) {
      const Corners& corners = corners_[static_cast<std::size_t>(face)];
      if (bound.of(corners) > 0) return;
      for (std::size_t i = 0; i < 3; ++i) {
        const Vector3 along = t[(i + 1) % 3] - t[i];
        const double share = hit_by_ray(t[i], along, corners);
        if (share > 1) continue;
        visit(i, Vector3(t[i] + share * along), face,
              faces_[static_cast<std::size_t>(face)].normal);
      }
    };
    double touching = 0;
    if (surroundings) {
      for (const int face : surroundings->faces) look(face);
    } else {
      face_tree_.search(bound, touching, look);
    }
  }

  /// Bound on the depth [m] to which a flat triangle with edges of at most `edge` [m] and its
  /// corners on the surface dips into the solid.
  double dip(double edge) const;

  /// Largest angle at which the surface bends outwards; a sheet may bend at any [rad].
  double sharpest() const { return is_sheet_ ? M_PI : sharpest_; }

  /// Thickness below all but a hundredth of the surface [m].
  double thickness() const { return thickness_; }

  const Box& box() const { return box_; }
  double radius() const { return radius_; }  // of the ball about the origin that holds it [m]

  const std::vector<Vector3>& vertices() const { return vertices_; }
  const std::vector<std::array<int, 3>>& triangles() const { return triangles_; }

 private:
  using Corners = std::array<Vector3, 3>;
  struct Face {
    Vector3 normal;                       // unit; zero where it has no area
    std::array<Vector3, 3> edge_normals;  // of the edge from corner i on
  };
  /// A triangle and its point nearest to another one.
  struct Nearest {
    double squared = infinity;
    int face = -1;
    Vector3 gap = Vector3::Zero();  // from the surface to the point
    std::array<double, 3> weights{1, 0, 0};

    /// Ties go to the first triangle, so that the result does not depend on the order of the
    /// search.
    bool is_before(const Nearest& other) const {
      return squared < other.squared || (squared == other.squared && face < other.face);
    }
  };
  class NearestFew;
  /// Smaller distances, by the solid's size, have no direction but for rounding; the same for a
  /// corner's weight.
  static constexpr double smallest = 1e-9;
  /// Lower bounds on squared distances from a triangle [m^2]: from its box, and from its plane.
  class TriangleBound {
   public:
    explicit TriangleBound(const Corners& t)
        : box_(Box(t[0]).extend(t[1]).extend(t[2])),
          normal_((t[1] - t[0]).cross(t[2] - t[0]).stableNormalized()),
          abs_normal_(normal_.cwiseAbs()),
          height_(normal_.dot(t[0])) {}

    double operator()(const Box& b) const {
      const Vector3 sum = b.min() + b.max(), size = b.max() - b.min();
      const double off = (std::abs(normal_.dot(sum) - 2 * height_) - abs_normal_.dot(size)) / 2;
      return std::max(squared_distance(b, box_), off > 0 ? off * off : 0);
    }

    /// Bound for the hull of these points.
    template <std::size_t count>
    double of(const std::array<Vector3, count>& points) const {
      Box box;
      double low = infinity, high = -low;
      for (const Vector3& p : points) {
        const double off = normal_.dot(p) - height_;
        low = std::min(low, off);
        high = std::max(high, off);
        box.extend(p);
      }
      const double off = std::max({low, -high, 0.0});
      return std::max(squared_distance(box, box_), off * off);
    }

   private:
    Box box_;
    Vector3 normal_;
    Vector3 abs_normal_;
    double height_;
  };
  /// A ball around a triangle. In single precision, so that many of them stay in the cache.
  struct Ball {
    float x, y, z;
    float radius;  // a little more than needed [m]
  };
  struct Candidate {
    int face;
    float least;  // lower bound on its distance from the cell's centre [m]
  };

  void weld(const TriangleSoup&);
  void orient();
  void add_faces();
  void connect();
  void connect_sheet();
  void add_ridge(std::size_t face, std::size_t corner, const Vector3& normal, double angle);
  void find_ridges(const std::vector<std::array<int, 3>>& beyond);
  double band() const;
  void build_grid();
  std::vector<char> cells_near_surface(double reach) const;
  void count_steps();
  void forget_steps_inside();
  void find_candidates(const Vector3& center, double reach);
  double measure_thickness() const;
  double thickness_below(std::size_t face) const;
  Nearest look_at(int face, const Vector3& point) const;
  template <class Visit>
  void visit_candidates(int cell, const Vector3& point, const double& most,
                        const Visit& visit) const;
  void wrap_faces();
  Nearest nearest_by_tree(const Vector3& point, double most) const;
  Nearest nearest_of(Neighbourhood&, const Vector3& point, double moved) const;
  Vector3 normal_at(const Nearest&) const;
  std::pair<double, Vector3> signed_distance(const Nearest&) const;
  bool has_candidates(std::size_t cell) const { return first_of_[cell] < first_of_[cell + 1]; }

  /// Lower bound on the distance of a point in a cell from the triangles that are no candidates
  /// there [m].
  double beyond_candidates(int cell, const Vector3& point) const;

  int cell_of(const Vector3& point) const;
  Vector3 center_of(int cell) const;

  bool is_sheet_;
  std::vector<Vector3> vertices_;
  std::vector<std::array<int, 3>> triangles_;
  std::vector<Corners> corners_;  // of the triangles; few queries need their normals
  std::vector<Ball> balls_;       // about them
  std::vector<Face> faces_;
  std::vector<Vector3> vertex_normals_;
  std::vector<Ridge> ridges_;
  Box box_;
  double radius_ = 0;
  double thickness_ = 0;
  double sharpest_ = 0;   // angle of a ridge [rad]
  double curvature_ = 0;  // largest, by the angles of ridges [1/m]

  NearestTree face_tree_{{}};
  NearestTree ridge_tree_{{}};
  double cell_ = 0;             // size of a cell [m]
  std::array<int, 3> cells_{};  // along each axis
  std::vector<int> first_of_;   // by cell, and one more: its first candidate
  std::vector<Candidate> candidates_;
  // By cell: lower bound on the steps to the next cell with candidates, over corners too; 0 for
  // those cells, and inside the solid.
  std::vector<unsigned char> steps_;
};

}  // namespace clothsim
