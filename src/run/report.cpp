#include "clothsim/run/report.h"

#include <yaml-cpp/yaml.h>

#include <algorithm>

#include "clothsim/dynamics/energy.h"
#include "clothsim/dynamics/stretch.h"
#include "clothsim/geometry/intersections.h"
#include "clothsim/shapes/face_distance.h"
#include "clothsim/shapes/shape.h"

namespace clothsim {

double deepest_penetration(const Simulator& simulator) {
  const Points& positions = simulator.state().positions;
  const std::vector<ColliderSpec>& colliders = simulator.scene().colliders;
  double deepest = 0;
  for (size_t c = 0; c < colliders.size(); ++c) {
    if (!simulator.collider_enabled(static_cast<int>(c))) continue;
    const Shape& shape = colliders[c].shape;
    const Pose& pose = simulator.collider_pose(static_cast<int>(c));
    const Eigen::Matrix3d to_shape = pose.orientation.conjugate().toRotationMatrix();
    const auto local = [&](int i) -> Vector3 {
      return to_shape * (positions.row(i).transpose() - pose.position);
    };
    for (int i = 0; i < positions.rows(); ++i) {
      deepest = std::max(deepest, -signed_distance(shape, local(i), local(i)).value);
    }
    for (const auto& [i, j, k] : simulator.cloth().triangles) {
      const auto distance = face_distance(shape, {local(i), local(j), local(k)}, 0);
      if (distance) deepest = std::max(deepest, -distance->value);
    }
  }
  return deepest;
}

void RunReport::add(const StepReport& frame) {
  last_frame = frame;
  ++frames;
  recoveries += frame.recoveries;
  ran_out += frame.ran_out;
  held_back += frame.held_back;
  if (frame.pinched > pinched) {
    pinched = frame.pinched;
    pinched_point = frame.pinched_point;
  }
}

std::string to_yaml(const RunReport& run, const Simulator& simulator) {
  const Scene& scene = simulator.scene();
  const Cloth& cloth = simulator.cloth();
  const State& state = simulator.state();
  const Stretch stretch = measure_stretch(cloth, state.positions);

  YAML::Emitter yaml;
  const auto put = [&](const char* key, const auto& value) {
    yaml << YAML::Key << key << YAML::Value << value;
  };
  yaml << YAML::BeginMap;
  put("scene", run.scene);
  yaml << YAML::Key << "overrides" << YAML::Value << YAML::Flow << run.overrides;
  put("method", run.last_frame.method);
  put("substeps", run.last_frame.substeps);
  if (run.last_frame.predicted_error) put("predicted_error", *run.last_frame.predicted_error);
  put("reason", run.last_frame.reasons.text());
  put("recoveries", run.recoveries);
  put("self_collision", self_collision_names[static_cast<std::size_t>(cloth.self_collision)]);
  put("ran_out", run.ran_out);
  put("held_back", run.held_back);
  put("pinched", run.pinched);
  if (run.pinched > 0) put("pinched_point", run.pinched_point);
  put("frames", run.frames);
  put("simulated_seconds", state.time);
  put("wall_seconds", run.wall_seconds);
  put("cpu_seconds", run.cpu_seconds);
  put("worst_stretch", stretch.worst);
  put("mean_stretch", stretch.mean);
  put("rms_velocity", rms_velocity(state));
  yaml << YAML::Key << "energy" << YAML::Value << YAML::BeginMap;
  put("kinetic", kinetic_energy(cloth, state));
  put("elastic", elastic_energy(cloth, state.positions));
  put("gravitational", gravitational_energy(cloth, scene.simulation.gravity, state.positions));
  yaml << YAML::EndMap;
  put("contacts", run.last_frame.contacts);
  put("intersecting_pairs", count_intersections(cloth, state.positions));
  put("deepest_penetration", deepest_penetration(simulator));
  put("diverged", !run.error.empty());
  if (!run.error.empty()) put("error", run.error);
  yaml << YAML::EndMap;
  return std::string(yaml.c_str()) + "\n";
}

}  // namespace clothsim
