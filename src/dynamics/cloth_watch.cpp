#include "clothsim/dynamics/cloth_watch.h"

#include <algorithm>

namespace clothsim {
namespace {

bool same(const SpringRun& a, const SpringRun& b) {
  return a.first == b.first && a.offset == b.offset && a.count == b.count &&
         a.rest_length == b.rest_length && a.stiffness == b.stiffness;
}

bool same(const BendRun& a, const BendRun& b) {
  return a.first == b.first && a.a == b.a && a.b == b.b && a.count == b.count &&
         a.stiffness == b.stiffness;
}

bool same(const CellRun& a, const CellRun& b) {
  return a.first == b.first && a.a == b.a && a.b == b.b && a.count == b.count &&
         a.strain == b.strain && a.stiffness == b.stiffness;
}

bool same(const PatchBend& a, const PatchBend& b) {
  return a.points == b.points && a.coefficients == b.coefficients && a.stiffness == b.stiffness &&
         a.curvature == b.curvature;
}

template <typename Run>
bool same(const std::vector<Run>& a, const std::vector<Run>& b) {
  return std::equal(a.begin(), a.end(), b.begin(), b.end(),
                    [](const Run& x, const Run& y) { return same(x, y); });
}

/// The same mesh and stiffness; null for a grid.
bool same(const std::shared_ptr<const TriangleFabric>& a,
          const std::shared_ptr<const TriangleFabric>& b) {
  if (a == b || !a || !b) return a == b;
  const auto alike = [](const TriangleFabric::Triangle& s, const TriangleFabric::Triangle& t) {
    return s.edges == t.edges && s.rest2 == t.rest2 && s.stretch == t.stretch && s.mass == t.mass;
  };
  const auto damped_alike = [](const TriangleFabric::Piece& p, const TriangleFabric::Piece& q) {
    return p.first_point == q.first_point && p.internal_damping == q.internal_damping;
  };
  return a->edges == b->edges && same(a->bends, b->bends) &&
         std::equal(a->pieces.begin(), a->pieces.end(), b->pieces.begin(), b->pieces.end(),
                    damped_alike) &&
         std::equal(a->triangles.begin(), a->triangles.end(), b->triangles.begin(),
                    b->triangles.end(), alike);
}

bool same(const Scalars& a, const Scalars& b) { return a.size() == b.size() && a == b; }

}  // namespace

bool ClothWatch::differs(const Cloth& cloth, double h) const {
  const bool same_forces =
      same(cloth.springs, springs_) && same(cloth.bends, bends_) && same(cloth.cells, cells_) &&
      same(cloth.triangle_fabric, triangle_fabric_) && cloth.internal_damping == internal_damping_;
  return !(same_forces && h == h_ && cloth.damping == damping_ && cloth.dampings == dampings_ &&
           same(cloth.mass, mass_) && same(cloth.inv_mass, inv_mass_));
}

bool ClothWatch::changed(const Cloth& cloth, double h) {
  const bool differed = differs(cloth, h);
  triangle_fabric_ = cloth.triangle_fabric;  // equal ones are then known by their address
  if (!differed) return false;
  h_ = h;
  damping_ = cloth.damping;
  dampings_ = cloth.dampings;
  mass_ = cloth.mass;
  inv_mass_ = cloth.inv_mass;
  springs_ = cloth.springs;
  bends_ = cloth.bends;
  cells_ = cloth.cells;
  internal_damping_ = cloth.internal_damping;
  return true;
}

}  // namespace clothsim
