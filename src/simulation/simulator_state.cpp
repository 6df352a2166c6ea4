// States from and for a simulator.

#include <algorithm>
#include <array>
#include <utility>

#include "clothsim/dynamics/cloth_watch.h"
#include "clothsim/geometry/intersections.h"
#include "clothsim/model/checks.h"
#include "clothsim/simulation/saved.h"
#include "simulator_impl.h"

namespace clothsim {
namespace {

/// Increases when the numbers that make up a memory change.
enum { memory_version = 19 };

std::string vector_text(const Vector3& v) {
  return "[" + to_text(v.x()) + ", " + to_text(v.y()) + ", " + to_text(v.z()) + "]";
}

/// Properties of a scene on which the numbers of a memory depend.
using MemoryShape = std::array<double, 9>;

MemoryShape shape_of(const Scene& scene, const Cloth& cloth) {
  const std::vector<std::string> names = method_names();
  const std::string method = choose_method(scene.simulation, cloth, scene.colliders).method;
  const auto place = std::find(names.begin(), names.end(), method) - names.begin();
  return {static_cast<double>(memory_version),
          static_cast<double>(cloth.columns),
          static_cast<double>(cloth.rows),
          static_cast<double>(cloth.num_springs()),
          static_cast<double>(cloth.strain_limit.has_value()),
          static_cast<double>(cloth.self_collision),
          static_cast<double>(scene.colliders.size()),
          static_cast<double>(scene.simulation.method == "auto"),
          static_cast<double>(place)};
}

bool has_other_material(const Cloth& a, const Cloth& b) {
  ClothWatch watch;
  watch.changed(a, 0);  // whatever the step
  return watch.differs(b, 0);
}

/// Throws InvalidValue unless there are `count`, each below `limit`.
void check_points(const std::string& key, const Points& points, int count, double limit,
                  const char* unit) {
  if (points.rows() != count) {
    throw InvalidValue({key}, std::to_string(points.rows()) + " points", std::to_string(count));
  }
  for (int i = 0; i < count; ++i) {
    const Vector3 p = points.row(i).transpose();
    if (!(p.cwiseAbs().array() < limit).all()) {  // true for NaN
      throw InvalidValue({key, std::to_string(i)}, vector_text(p),
                         "finite numbers below " + to_text(limit) + unit);
    }
  }
}

MemoryReader after_shape(const std::vector<double>& numbers) {
  MemoryReader memory(numbers);
  for (std::size_t i = 0; i < MemoryShape().size(); ++i) memory.number();
  return memory;
}

/// By collider: whether it leads a rigid body.
std::vector<char> leads_of(const RigidBodies& bodies, std::size_t num_colliders) {
  std::vector<char> leads;
  for (std::size_t k = 0; k < num_colliders; ++k) leads.push_back(bodies.leads(k));
  return leads;
}

}  // namespace

void Simulator::Impl::write(MemoryWriter& memory) const {
  for (const double number : shape_of(scene, without_grips())) memory.add(number);
  const std::vector<std::string> names = method_names();
  const auto place = std::find(names.begin(), names.end(), method->choice.method);
  memory.add(static_cast<double>(place - names.begin()));
  memory.add(disturbed);
  memory.add(is_given);
  energy_watch.write(memory);
  if (const auto* bdf2 = std::get_if<Bdf2>(&method->integrator)) bdf2->write(memory, cloth);
  if (strain_limit) strain_limit->write(memory);
  collider_contacts.write(memory, colliders, state.positions);
  memory.add(knows_offset ? cloth.offset : 0);
  lagged_contact.write(memory);
  if (self_contacts) self_contacts->write(memory);
  bodies.write(memory);
  if (!bodies.empty()) body_contacts.write(memory);
  attachments.write(memory);
  holders.write(memory);
}

bool Simulator::Impl::fits(const std::vector<double>& memory) const {
  const MemoryShape shape = shape_of(scene, without_grips());
  return memory.size() >= shape.size() && std::equal(shape.begin(), shape.end(), memory.begin());
}

Method Simulator::Impl::read_method(MemoryReader& memory) const {
  const Cloth free = without_grips();
  Method method_of_scene(scene.simulation, free, scene.colliders);
  const std::vector<std::string> names = method_names();
  const std::string& name = names[static_cast<std::size_t>(memory.index(names.size()))];
  if (name == method_of_scene.choice.method) return method_of_scene;
  if (scene.simulation.method != "auto" || name != fallback_method) {
    throw InvalidValue({"memory"}, "method " + name, method_of_scene.choice.method);
  }
  return last_resort(scene.simulation, free, scene.colliders, Reason::failed_before_set_state);
}

void Simulator::Impl::read(const std::vector<double>& numbers) {
  if (!fits(numbers)) {
    throw InvalidValue({"memory"}, "that of another cloth, scene or method",
                       "one that this simulation gave as it is now, or none");
  }
  MemoryReader memory = after_shape(numbers);
  Method new_method = read_method(memory);
  const bool read_disturbed = memory.index(2) == 1, read_given = memory.index(2) == 1;
  EnergyWatch read_energy_watch;
  read_energy_watch.read(memory);
  if (auto* bdf2 = std::get_if<Bdf2>(&new_method.integrator)) bdf2->read(memory, cloth);

  std::optional<StrainLimit> read_limit = strain_limit;
  if (read_limit) read_limit->read(memory);
  ColliderContacts read_contacts;
  read_contacts.read(memory, colliders.size(), cloth);
  const double read_offset = std::clamp(memory.number(), 0.0, cloth.full_offset);
  LaggedContact read_lagged;
  read_lagged.read(memory, cloth);
  std::optional<SelfContacts> read_self_contacts = self_contacts;
  if (read_self_contacts) read_self_contacts->read(memory);
  RigidBodies read_bodies = bodies;
  read_bodies.read(memory);
  BodyContacts read_body_contacts = body_contacts;
  if (!bodies.empty()) read_body_contacts.read(memory, colliders.size());
  BodyAttachments read_attachments = attachments;
  read_attachments.read(memory);
  Holders read_holders = holders;
  read_holders.read(memory);
  memory.finish();

  method = std::move(new_method);
  strain_limit = std::move(read_limit);
  collider_contacts = std::move(read_contacts);
  knows_offset = read_offset > 0;
  if (knows_offset) cloth.offset = read_offset;
  lagged_contact = std::move(read_lagged);
  self_contacts = std::move(read_self_contacts);
  bodies = std::move(read_bodies);
  body_contacts = std::move(read_body_contacts);
  attachments = std::move(read_attachments);
  holders = std::move(read_holders);
  follow_holders();
  if (auto* bdf2 = std::get_if<Bdf2>(&method->integrator)) bdf2->resume(cloth);
  restore_velocities(true);
  disturbed = read_disturbed;
  is_given = read_given;
  energy_watch = read_energy_watch;
}

void Simulator::Impl::set_state(const State& given, const std::vector<double>& memory) {
  check_points("positions", given.positions, cloth.num_points(), farthest, " [m]");
  check_points("velocities", given.velocities, cloth.num_points(), max_given_speed, " [m/s]");
  if (!(given.time >= 0 && given.time < farthest)) {
    throw InvalidValue({"time"}, to_text(given.time),
                       "a number from 0 to below " + to_text(farthest) + " [s]");
  }
  // The end of the memory has the data of the holders, with the points that stick.
  Holders given_holders = holders;
  if (memory.size() >= holders.memory_size()) {
    const auto size = static_cast<std::ptrdiff_t>(holders.memory_size());
    const std::vector<double> last(memory.end() - size, memory.end());
    MemoryReader reader(last);
    given_holders.read(reader);
  }
  Cloth held_cloth = cloth;
  given_holders.apply(held_cloth);
  for (int i = 0; i < cloth.num_points(); ++i) {
    if (held_cloth.inv_mass[i] > 0) continue;
    const Vector3 here = given.positions.row(i).transpose();
    const Vector3 held = state.positions.row(i).transpose();
    if ((here - held).norm() > written_rounding) {
      throw InvalidValue({"positions", std::to_string(i)}, vector_text(here),
                         vector_text(held) + ", where the point is held");
    }
  }

  if (memory.empty()) {
    forget();
    disturbed = is_given = true;
  } else {
    read(memory);
  }
  const State last = state;
  state = given;  // `given` may be the same object
  for (int i = 0; i < cloth.num_points(); ++i) {
    if (cloth.inv_mass[i] > 0) continue;
    state.positions.row(i) = last.positions.row(i);
    state.velocities.row(i) = last.velocities.row(i);
  }
  collider_contacts.find_jumps(colliders, cloth, state.positions);
  look_for_crossings();
}

void Simulator::Impl::look_for_crossings() {
  given_crossings = 0;
  if (cloth.self_collision != SelfCollision::surface) return;
  if (scene.cloth.untangle) {
    untangle();
  } else {
    given_crossings = count_intersections(cloth, state.positions);
  }
}

Untangled Simulator::Impl::untangle() {
  const Untangled result = clothsim::untangle(cloth, colliders, state.positions, is_interrupted);
  if (result.before > 0) {
    forget();
    disturbed = is_given = true;
  }
  given_crossings = cloth.self_collision == SelfCollision::surface ? result.left : 0;
  return result;
}

int Simulator::given_crossings() const { return impl_->given_crossings; }
Untangled Simulator::untangle() { return impl_->untangle(); }

void Simulator::load(const Scene& scene) {
  auto loaded = std::make_unique<Impl>(scene);
  loaded->topology_seq = impl_->topology_seq + 1;
  loaded->is_interrupted = impl_->is_interrupted;
  loaded->measures_wrenches = impl_->measures_wrenches;
  impl_ = std::move(loaded);
}

std::vector<double> Simulator::memory() const {
  MemoryWriter memory;
  impl_->write(memory);
  return memory.numbers();
}

void Simulator::set_state(const State& state, const std::vector<double>& memory) {
  impl_->set_state(state, memory);
}

std::shared_ptr<const Simulator::Saved> Simulator::save() const {
  return std::make_shared<const Saved>(
      Saved{impl_->cloth, impl_->state, memory(), impl_->colliders, impl_->pin_targets,
            impl_->grips, impl_->collider_wrenches, impl_->external_forces, impl_->last_substep,
            impl_->given_crossings, frame_duration(), impl_->scene.simulation.gravity,
            leads_of(impl_->bodies, impl_->colliders.size())});
}

std::size_t Simulator::bytes_of(const Saved& saved) {
  const auto bytes = [](const auto& list) {
    return static_cast<std::size_t>(list.size()) * sizeof(*list.data());
  };
  const Cloth& cloth = saved.cloth;
  std::size_t held = 0;
  for (const auto& [frame, grip] : saved.grips.all()) {
    held += sizeof(Grip) + bytes(frame) + bytes(grip.held) + bytes(grip.bodies);
  }
  std::size_t bytes_of_bands =
      bytes(cloth.cells) + bytes(cloth.pairs) + bytes(cloth.bend_bands) + bytes(cloth.cell_bands);
  for (const PairBand& band : cloth.pairs) bytes_of_bands += bytes(band.spring) + bytes(band.bend);
  for (const BendBand& band : cloth.bend_bands) bytes_of_bands += bytes(band.stiffness);
  for (const CellBand& band : cloth.cell_bands) bytes_of_bands += bytes(band.stiffness);
  return held + bytes(cloth.rest_positions) + bytes(cloth.uv) + bytes(cloth.triangles) +
         bytes(cloth.springs) + bytes(cloth.bends) + bytes_of_bands + bytes(cloth.mass) +
         bytes(cloth.first_points) + bytes(cloth.first_triangles) + bytes(cloth.frictions) +
         bytes(cloth.thicknesses) + bytes(saved.leads) + bytes(cloth.inv_mass) +
         bytes(cloth.pinned) + bytes(saved.state.positions) + bytes(saved.state.velocities) +
         bytes(saved.memory) + bytes(saved.colliders) + bytes(saved.pin_targets) +
         bytes(saved.collider_wrenches) + bytes(saved.forces);
}

void Simulator::restore(const Saved& saved) {
  const Cloth& cloth = impl_->cloth;
  const auto same = [](const MovingCollider& a, const MovingCollider& b) {
    return a.shape() == b.shape();
  };
  if (saved.cloth.columns != cloth.columns || saved.cloth.rows != cloth.rows ||
      saved.cloth.rest_positions != cloth.rest_positions || saved.cloth.pinned != cloth.pinned ||
      !std::equal(saved.colliders.begin(), saved.colliders.end(), impl_->colliders.begin(),
                  impl_->colliders.end(), same) ||
      saved.leads != leads_of(impl_->bodies, impl_->colliders.size())) {
    throw InvalidValue({"state"}, "that of another scene", "one of this scene");
  }
  for (const auto& [frame, grip] : saved.grips.all()) {
    bool fits = !grip.on_body || impl_->bodies.leads(*grip.on_body);
    for (const Grip::HeldBody& b : grip.bodies) fits = fits && impl_->bodies.leads(b.leader);
    for (const Grip::Held& h : grip.held) {
      fits = fits && h.point >= 0 && h.point < cloth.num_points();
    }
    if (fits) continue;
    throw InvalidValue({"state"}, "points or bodies that the scene has not", "one of this scene");
  }
  impl_->grips = saved.grips;
  impl_->hold_points();
  if (impl_->fits(saved.memory)) {
    impl_->renew_self_contacts(cloth, saved.cloth);  // those of its memory
    impl_->read(saved.memory);
    const bool is_other_material = has_other_material(saved.cloth, cloth);
    if (is_other_material) impl_->forget_history();
    if (is_other_material || saved.gravity != impl_->scene.simulation.gravity) {
      impl_->energy_watch.restart();
    }
    impl_->renew_self_contacts(saved.cloth, cloth);
    impl_->disturbed = impl_->disturbed || !has_same_thickness(saved.cloth, cloth);
  } else {
    impl_->forget();  // springs or the method have changed since
    impl_->disturbed = true;
  }
  impl_->state = saved.state;
  impl_->colliders = saved.colliders;
  impl_->restore_velocities(impl_->fits(saved.memory));
  impl_->set_collider_friction();
  impl_->pin_targets = saved.pin_targets;
  impl_->collider_wrenches = saved.collider_wrenches;
  impl_->external_forces = saved.forces;
  impl_->last_substep = saved.last_substep;
  impl_->given_crossings = saved.given_crossings;
  if (saved.frame_duration == frame_duration()) return;
  impl_->renew_targets();
}

}  // namespace clothsim
