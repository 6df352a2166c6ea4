#include "clothsim/constraints/self_contacts.h"

namespace clothsim {

std::optional<SelfContacts> make_self_contacts(const Cloth& cloth) {
  switch (cloth.self_collision) {
    case SelfCollision::points:
      return PointContacts();
    case SelfCollision::surface:
      return SurfaceContacts(cloth);
    default:
      return std::nullopt;
  }
}

}  // namespace clothsim
