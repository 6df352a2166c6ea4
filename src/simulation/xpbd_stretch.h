#pragma once

#include <optional>
#include <string>

#include "clothsim/model/cloth.h"
#include "clothsim/scene/scene.h"

namespace clothsim {

/// The largest stretch of the cloth by XPBD with so many substeps a frame, and the number of
/// substeps with which it hardly shows. Empty where it hardly does, where a strain limit prevents
/// it, and for a grid that pins hold or that has no colliders.
std::optional<std::string> xpbd_stretch_text(const SimulationSpec&, const Cloth&,
                                             bool over_colliders, int substeps);

}  // namespace clothsim
