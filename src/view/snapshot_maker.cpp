#include "clothsim/view/snapshot_maker.h"

namespace clothsim {

Snapshot SnapshotMaker::make(const Simulator& simulator, const PreparedView& view) {
  // A rope has its thickness in the mesh, which may change.
  if (simulator_ != &simulator || topology_seq_ != simulator.topology_seq() ||
      cloth_->thickness != simulator.cloth().thickness) {
    simulator_ = &simulator;
    topology_seq_ = simulator.topology_seq();
    cloth_ = std::make_shared<const Cloth>(simulator.cloth());
    positions_.reset();
  }
  const Points& positions = simulator.state().positions;
  if (!positions_ || *positions_ != positions)
    positions_ = std::make_shared<const Points>(positions);

  Snapshot snapshot;
  snapshot.time = simulator.state().time;
  snapshot.cloth = cloth_;
  snapshot.positions = positions_;
  snapshot.cloth_shading = view.cloth;
  if (!view.cloths.empty()) {
    for (const ClothPart& part : simulator.scene().cloth.parts) {
      const auto named = view.cloths.find(part.name);
      snapshot.cloth_shadings.push_back(named == view.cloths.end() ? view.cloth : named->second);
    }
  }
  snapshot.light = view.light;
  snapshot.background = view.background;
  const std::vector<ColliderSpec>& colliders = simulator.scene().colliders;
  for (std::size_t i = 0; i < colliders.size(); ++i) {
    const auto named = view.colliders.find(colliders[i].name);
    ColliderView collider = named == view.colliders.end() ? view.collider : named->second;
    collider.shape = colliders[i].shape;
    collider.pose = simulator.collider_pose(static_cast<int>(i));
    collider.visible = simulator.collider_enabled(static_cast<int>(i));
    snapshot.colliders.push_back(collider);
  }
  return snapshot;
}

}  // namespace clothsim
