#pragma once

#include <cereal/archives/portable_binary.hpp>
#include <cereal/types/array.hpp>
#include <cereal/types/map.hpp>
#include <cereal/types/optional.hpp>
#include <cereal/types/set.hpp>
#include <cereal/types/string.hpp>
#include <cereal/types/vector.hpp>
#include <variant>

#include "clothsim/run/report.h"
#include "clothsim/simulation/saved.h"

// serialize() of each type, in the types' namespaces, for writing and reading by cereal.

namespace cereal {

template <class Archive>
void serialize(Archive& archive, Eigen::Vector3d& vector) {
  archive(vector.x(), vector.y(), vector.z());
}

template <class Archive>
void serialize(Archive& archive, Eigen::Quaterniond& turn) {
  archive(turn.x(), turn.y(), turn.z(), turn.w());
}

template <class Archive>
void serialize(Archive& archive, clothsim::Points& points) {
  Eigen::Index rows = points.rows();
  archive(rows);
  points.resize(rows, Eigen::NoChange);
  archive(binary_data(points.data(), static_cast<std::size_t>(points.size()) * sizeof(double)));
}

template <class Archive>
void serialize(Archive& archive, clothsim::Pose& pose) {
  archive(pose.position, pose.orientation);
}

template <class Archive>
void serialize(Archive& archive, clothsim::Twist& twist) {
  archive(twist.linear, twist.angular);
}

template <class Archive>
void serialize(Archive& archive, clothsim::Wrench& wrench) {
  archive(wrench.force, wrench.torque);
}

template <class Archive>
void serialize(Archive& archive, clothsim::State& state) {
  archive(state.positions, state.velocities, state.time);
}

template <class Archive>
void serialize(Archive& archive, clothsim::Grip::Held& held) {
  archive(held.point, held.offset);
}

template <class Archive>
void serialize(Archive& archive, clothsim::Grip::HeldBody& body) {
  archive(body.leader, body.offset);
}

template <class Archive>
void serialize(Archive& archive, clothsim::Grip& grip) {
  archive(grip.held, grip.bodies, grip.pose, grip.tear_force, grip.strength, grip.on_body,
          grip.wrench, grip.lag);
}

template <class Archive>
void serialize(Archive& archive, clothsim::Fabric& fabric) {
  archive(fabric.stretch_stiffness, fabric.shear_stiffness, fabric.bending_stiffness,
          fabric.internal_damping, fabric.poisson);
}

template <class Archive>
void serialize(Archive& archive, clothsim::Material& material) {
  archive(material.ks, material.fabric, material.density, material.damping, material.drag,
          material.strain_limit, material.springs);
}

/// Parameters are those of the method, or none.
template <class Archive>
void serialize(Archive& archive, clothsim::SimulationSpec& spec) {
  archive(spec.gravity, spec.wind, spec.gusts, spec.frames_per_second, spec.substeps,
          spec.strain_tolerance, spec.tolerance, spec.method, spec.seed, spec.threads);
  bool has_parameters = !std::holds_alternative<std::monostate>(spec.method_parameters);
  archive(has_parameters);
  if (!has_parameters) return;
  if (Archive::is_loading::value) {
    spec.method_parameters = clothsim::default_parameters(spec.method);
  }
  std::visit(
      [&](auto& parameters) {
        using Parameters = std::decay_t<decltype(parameters)>;
        if constexpr (!std::is_same_v<Parameters, std::monostate>) {
          Parameters::each(parameters, [&](const char*, auto& value, auto&&) { archive(value); });
        }
      },
      spec.method_parameters);
}

template <class Archive>
void serialize(Archive& archive, clothsim::LiveSpec::OfCloth& cloth) {
  archive(cloth.name, cloth.material, cloth.friction, cloth.thickness);
}

template <class Archive>
void serialize(Archive& archive, clothsim::LiveSpec& live) {
  archive(live.material, live.thickness, live.self_collision, live.friction, live.collider_friction,
          live.simulation, live.cloths);
}

template <class Archive>
void serialize(Archive& archive, clothsim::StepReport& report) {
  archive(report.method, report.substeps, report.predicted_error, report.reasons, report.recoveries,
          report.sweeps, report.corrections, report.worst_stretch, report.violation,
          report.contacts, report.added_mass, report.ran_out, report.held_back, report.pinched,
          report.pinched_point, report.slipping, report.lagging, report.crossings);
}

template <class Archive>
void serialize(Archive& archive, clothsim::RunReport& report) {
  archive(report.scene, report.overrides, report.frames, report.wall_seconds, report.cpu_seconds,
          report.last_frame, report.recoveries, report.ran_out, report.held_back, report.pinched,
          report.pinched_point, report.error);
}

/// Shapes and friction of colliders belong to the scene, and so does the cloth.
template <class Archive>
void serialize(Archive& archive, clothsim::Simulator::Saved& saved) {
  archive(saved.state, saved.memory, saved.pin_targets, saved.grips, saved.collider_wrenches,
          saved.forces, saved.last_substep, saved.given_crossings, saved.frame_duration,
          saved.gravity);
  for (clothsim::MovingCollider& collider : saved.colliders) {
    clothsim::Pose pose = collider.pose();
    clothsim::Pose target = collider.target();
    clothsim::Twist twist{collider.velocity(), collider.angular_velocity()};
    bool enabled = collider.enabled();
    archive(pose, target, twist, enabled);
    if (!Archive::is_loading::value) continue;
    collider.place(pose);
    if (same(target, pose)) {
      collider.move_to(pose, twist.linear, twist.angular);  // of a body; others are at rest
      collider.begin_step();
    } else {
      // After a frame that failed, the target is still ahead.
      collider.set_target(target, saved.frame_duration);
    }
    collider.enable(enabled);
  }
}

}  // namespace cereal

namespace clothsim_python {

/// All of `parts` as bytes, one after the other.
template <class... Parts>
std::string to_bytes(const Parts&... parts) {
  std::ostringstream stream(std::ios::binary);
  cereal::PortableBinaryOutputArchive archive(stream);
  archive(parts...);
  return stream.str();
}

/// Reads the result of to_bytes() for parts of these types. Throws cereal::Exception.
template <class... Parts>
void from_bytes(const std::string& bytes, Parts&... parts) {
  std::istringstream stream(bytes, std::ios::binary);
  cereal::PortableBinaryInputArchive archive(stream);
  archive(parts...);
}

}  // namespace clothsim_python
