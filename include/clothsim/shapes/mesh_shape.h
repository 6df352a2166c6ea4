#pragma once

#include <memory>

#include "clothsim/shapes/shape_answers.h"

namespace clothsim {

struct FaceQuery;
struct MeshFile;

/// A solid of triangles in its own frame, or a sheet of them, grown by a padding with round edges:
/// a sheet on both sides.
struct MeshShape {
  static constexpr const char* name = "mesh";
  std::shared_ptr<const MeshFile> file;  // never null where distances are computed
  double padding = 0;                    // [m]

  // Members that shape.h requires.
  static constexpr bool is_convex = false;
  bool operator==(const MeshShape& m) const { return file == m.file && padding == m.padding; }
  double safe_depth() const;
  double bounding_radius() const;
  double corner_distance(double edge, double offset) const;
  NearSurface near_surface(double x, double y, double z, double) const;
  std::optional<double> entry(const Vector3& from, const Vector3& displacement,
                              double offset) const;
  std::optional<FaceDistance> face_distance(const Triangle& t, double reach) const;
  std::optional<FaceDistance> face_distance(const Triangle&, double reach, const FaceQuery&) const;
  void visit_lines(const Triangle&, const Vector3& normal, double reach, const VisitLine&) const;
  bool may_touch(const Box&, const Triangle*, double reach) const;
  bool may_touch(const Box&, const Triangle*, double reach, const FaceQuery&) const;
};

}  // namespace clothsim
