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

template <typename Run>
bool same(const std::vector<Run>& a, const std::vector<Run>& b) {
  return std::equal(a.begin(), a.end(), b.begin(), b.end(),
                    [](const Run& x, const Run& y) { return same(x, y); });
}

bool same(const Scalars& a, const Scalars& b) { return a.size() == b.size() && a == b; }

}  // namespace

bool ClothWatch::differs(const Cloth& cloth, double h) const {
  const bool same_forces = same(cloth.springs, springs_) && same(cloth.bends, bends_) &&
                           cloth.triangle_fabric == triangle_fabric_ &&
                           cloth.internal_damping == internal_damping_;
  return !(same_forces && h == h_ && cloth.damping == damping_ && same(cloth.mass, mass_) &&
           same(cloth.inv_mass, inv_mass_));
}

bool ClothWatch::changed(const Cloth& cloth, double h) {
  if (!differs(cloth, h)) return false;
  h_ = h;
  damping_ = cloth.damping;
  mass_ = cloth.mass;
  inv_mass_ = cloth.inv_mass;
  springs_ = cloth.springs;
  bends_ = cloth.bends;
  triangle_fabric_ = cloth.triangle_fabric;
  internal_damping_ = cloth.internal_damping;
  return true;
}

}  // namespace clothsim
