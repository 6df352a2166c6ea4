#include "clothsim/dynamics/cloth_watch.h"

#include <algorithm>

namespace clothsim {
namespace {

bool same(const SpringRun& a, const SpringRun& b) {
  return a.first == b.first && a.offset == b.offset && a.count == b.count &&
         a.rest_length == b.rest_length && a.stiffness == b.stiffness;
}

bool same(const Scalars& a, const Scalars& b) { return a.size() == b.size() && a == b; }

}  // namespace

bool ClothWatch::differs(const Cloth& cloth, double h) const {
  const bool same_springs =
      std::equal(springs_.begin(), springs_.end(), cloth.springs.begin(), cloth.springs.end(),
                 [](const SpringRun& a, const SpringRun& b) { return same(a, b); });
  return !(same_springs && h == h_ && cloth.damping == damping_ && same(cloth.mass, mass_) &&
           same(cloth.inv_mass, inv_mass_));
}

bool ClothWatch::changed(const Cloth& cloth, double h) {
  if (!differs(cloth, h)) return false;
  h_ = h;
  damping_ = cloth.damping;
  mass_ = cloth.mass;
  inv_mass_ = cloth.inv_mass;
  springs_ = cloth.springs;
  return true;
}

}  // namespace clothsim
