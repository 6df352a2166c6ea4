// Changes of values between two frames.

#include <algorithm>
#include <string>
#include <utility>

#include "clothsim/model/make_cloth.h"
#include "simulator_impl.h"

namespace clothsim {
namespace {

/// Do the springs of both join the same points, in the same order?
bool join_alike(const Cloth& one, const Cloth& other) {
  return std::equal(one.springs.begin(), one.springs.end(), other.springs.begin(),
                    other.springs.end(), [](const SpringRun& a, const SpringRun& b) {
                      return a.family == b.family && a.first == b.first && a.offset == b.offset &&
                             a.count == b.count;
                    });
}

/// Lets the offset from colliders grow from that of `last`, where a point gets a larger one.
void keep_offset(const Cloth& last, Cloth& now) {
  double offset = now.full_offset;
  for (int i = 0; i < now.num_points(); ++i) {
    if (now.offset_at(i) > last.offset_at(i)) offset = std::min(offset, last.offset_at(i));
  }
  now.offset = offset;
}

/// Gives the cloths of `spec` their values of `live`; see LiveSpec.
void set_cloths(const LiveSpec& live, ClothSpec& spec) {
  if (live.cloths.size() != spec.parts.size()) {
    throw InvalidValue({"cloths"}, std::to_string(live.cloths.size()) + " values",
                       std::to_string(spec.parts.size()) + ", one for each of several cloths");
  }
  if (spec.parts.empty()) {
    spec.material = live.material;
    spec.friction = live.friction;
    spec.thickness = live.thickness;
    return;
  }
  LiveSpec::OfCloth first = live.cloths.front();
  take_changes(spec.material, live.material, first.material);
  if (live.friction != spec.friction) first.friction = live.friction;
  if (live.thickness != spec.thickness) first.thickness = live.thickness;
  const LiveSpec::OfCloth& last = live.cloths.front();
  for (std::size_t i = 0; i < spec.parts.size(); ++i) {
    const LiveSpec::OfCloth& own = live.cloths[i];
    ClothPart& part = spec.parts[i];
    part.material = own.material;
    take_changes(last.material, first.material, part.material);
    part.friction = first.friction != last.friction ? first.friction : own.friction;
    part.thickness = first.thickness != last.thickness ? first.thickness : own.thickness;
  }
  spec.material = first.material;
  spec.friction = first.friction;
  spec.thickness = first.thickness;
}

}  // namespace

void Simulator::Impl::check_feasible(const SimulationSpec& spec, const Cloth& with,
                                     const std::vector<std::string>& key) const {
  if (spec.substeps) return;
  const Method chosen(spec, with, scene.colliders);
  if (chosen.substeps(spec, with, state.positions) < max_substeps) return;
  throw InvalidValue(
      key, "a cloth that needs " + std::to_string(max_substeps) + " substeps a frame or more",
      "a softer or heavier one, or more frames per second, or a count of substeps");
}

void Simulator::Impl::renew_self_contacts(const Cloth& last, const Cloth& now) {
  if (now.self_collision != last.self_collision || !has_same_thickness(last, now)) {
    self_contacts = make_self_contacts(now);
  } else if (now.mass != last.mass) {  // impulses of pairs depend on their masses
    if (self_contacts) self_contacts->reset();
  }
}

void Simulator::Impl::set_collider_friction() {
  for (std::size_t i = 0; i < colliders.size(); ++i) {
    colliders[i].set_friction(scene.colliders[i].friction);
  }
}

void Simulator::set(const LiveSpec& live) {
  validate(live);
  ClothSpec spec = impl_->scene.cloth;
  set_cloths(live, spec);
  spec.self_collision = live.self_collision;
  validate(spec);
  Cloth cloth = make_cloth(spec, live.simulation.gravity.norm());
  const bool springs_changed = !join_alike(impl_->cloth, cloth);
  const bool keeps_apart_anew = cloth.self_collision != impl_->cloth.self_collision;
  impl_->holders.apply(cloth);
  const bool is_fabric = spec.material.fabric.has_value();
  impl_->check_feasible(live.simulation, cloth,
                        is_fabric ? std::vector<std::string>{"stretch_stiffness", "0"}
                                  : std::vector<std::string>{"ks"});

  std::optional<Workers> workers;  // may throw: before the first change
  if (impl_->workers.threads() != live.simulation.threads) workers.emplace(live.simulation.threads);

  impl_->renew_self_contacts(impl_->cloth, cloth);
  const SimulationSpec& last = impl_->scene.simulation;
  const bool method_changed = live.simulation.method != last.method ||
                              !same(live.simulation.method_parameters, last.method_parameters);
  impl_->scene.cloth = std::move(spec);
  impl_->scene.simulation = live.simulation;
  for (ColliderSpec& collider : impl_->scene.colliders) {
    const auto friction = live.collider_friction.find(collider.name);
    if (friction != live.collider_friction.end()) collider.friction = friction->second;
  }
  impl_->set_collider_friction();
  impl_->renew_targets();
  if (workers) impl_->workers = std::move(*workers);
  if (impl_->knows_offset) keep_offset(impl_->cloth, cloth);
  impl_->cloth = std::move(cloth);
  std::optional<StrainLimit> last_limit = std::move(impl_->strain_limit);
  impl_->build_strain_limit();
  if (last_limit && impl_->strain_limit && !springs_changed) {
    impl_->strain_limit->take_over(std::move(*last_limit));
  }
  impl_->choose(method_changed);
  impl_->hold_points();
  if (keeps_apart_anew) impl_->look_for_crossings();
  if (springs_changed) ++impl_->topology_seq;
}

void Simulator::reset_values() { set(impl_->scene_values); }

void Simulator::set(const Material& material, const SimulationSpec& simulation) {
  LiveSpec live = live_values(impl_->scene);
  live.material = material;
  live.simulation = simulation;
  set(live);
}

void Simulator::set_material(const Material& material) { set(material, impl_->scene.simulation); }

void Simulator::set_simulation(const SimulationSpec& simulation) {
  set(impl_->scene.cloth.material, simulation);
}

void Simulator::set_wind(const Vector3& wind) {
  SimulationSpec changed = impl_->scene.simulation;
  changed.wind = wind;
  validate(changed);
  impl_->scene.simulation = changed;
}

void Simulator::Impl::choose(bool anew) {
  const Cloth free = without_grips();
  const MethodChoice choice = choose_method(scene.simulation, free, scene.colliders);
  if (anew || choice.method != method->choice.method) {
    method.emplace(scene.simulation, free, scene.colliders);
  } else {
    method->choice = choice;
    method->omega_max = omega_max_bound(free);
  }
}

}  // namespace clothsim
