#pragma once

#include <optional>
#include <variant>

#include "clothsim/constraints/point_contacts.h"
#include "clothsim/constraints/surface_contacts.h"

namespace clothsim {

/// How a cloth is kept off itself: one of a closed list of methods with one signature.
using SelfContacts = std::variant<PointContacts, SurfaceContacts>;

/// Those that `cloth` asks for, none where it may pass through itself.
std::optional<SelfContacts> make_self_contacts(const Cloth& cloth);

}  // namespace clothsim
