#include <string>
#include <utility>

#include "clothsim/model/checks.h"
#include "clothsim/scene/points_yaml.h"
#include "clothsim/scene/scene_yaml.h"
#include "clothsim/scene/yaml_values.h"

namespace clothsim {
namespace {

ReadValue into_points(PointReader& reader, std::vector<int>& points) {
  return [&](const YAML::Node& list) { points = read_points(list, reader); };
}

/// A quaternion [x, y, z, w] of any length.
Eigen::Quaterniond read_quaternion(const YAML::Node& node) {
  Eigen::Vector4d xyzw = Eigen::Vector4d::Zero();
  const bool has_four = node.IsSequence() && node.size() == 4;
  int i = 0;
  if (has_four) read_list(node, [&](const YAML::Node& item) { xyzw[i++] = read_number(item); });
  if (!has_four || !(xyzw.stableNorm() >= written_rounding)) {
    throw InvalidValue({}, describe(node), "a quaternion [x, y, z, w]");
  }
  return Eigen::Quaterniond(Eigen::Vector4d(xyzw.stableNormalized()));
}

// The keys of each kind of entry, apart from its own key and `time`.

std::vector<Field> fields(KeyFrame& key, PointReader&) {
  FrameTarget& target = key.target;
  const auto twist = [&target](Vector3 Twist::*part) {
    return [&target, part](const YAML::Node& node) {
      if (!target.twist) target.twist = Twist();
      (*target.twist).*part = read_vector(node);
    };
  };
  return {
      {"position", into(target.pose.position)},
      {"rpy", [&](const YAML::Node& node) { target.pose.orientation = read_roll_pitch_yaw(node); }},
      {"orientation",
       [&](const YAML::Node& node) { target.pose.orientation = read_quaternion(node); }},
      {"linear", twist(&Twist::linear)},
      {"angular", twist(&Twist::angular)}};
}

std::vector<Field> fields(KeyFrameFile& file, PointReader&) {
  return {{"frame", into(file.frame)}};
}

std::vector<Field> fields(AttachPoints& attach, PointReader& points) {
  return {{"points", into_points(points, attach.points)},
          {"radius", into(attach.radius)},
          {"tear_force", into(attach.tear_force)},
          {"strength", into(attach.strength)},
          {"body", into(attach.body)}};
}

std::vector<Field> fields(DetachPoints& detach, PointReader& points) {
  return {{"points", into_points(points, detach.points)}};
}

std::vector<Field> fields(SwitchCollider&, PointReader&) { return {}; }
std::vector<Field> fields(ChangeValues&, PointReader&) { return {}; }

/// A kind of entry: the key that identifies it, and its reader.
struct Kind {
  std::string key;
  MotionAction action;
  void (*read)(const YAML::Node&, MotionAction&);
};

template <auto member>
void read_name(const YAML::Node& node, MotionAction& action) {
  std::visit(
      [&](auto& kind) {
        if constexpr (std::is_invocable_v<decltype(member), decltype(kind)>)
          into(kind.*member)(node);
      },
      action);
}

/// In this order, as a file has a `frame` beside it.
std::vector<Kind> kinds() {
  const auto read_set = [](const YAML::Node& node, MotionAction& action) {
    action = read_change(node);
  };
  return {{"file", KeyFrameFile(), read_name<&KeyFrameFile::file>},
          {"frame", KeyFrame(), read_name<&KeyFrame::frame>},
          {"attach", AttachPoints(), read_name<&AttachPoints::frame>},
          {"detach", DetachPoints(), read_name<&DetachPoints::frame>},
          {"enable", SwitchCollider{"", true}, read_name<&SwitchCollider::collider>},
          {"disable", SwitchCollider{"", false}, read_name<&SwitchCollider::collider>},
          {"set", ChangeValues(), read_set}};
}

/// The reader for an entry: that of the cloth which its key `cloth` names.
PointReader& reader_for(const YAML::Node& entry, PointReaders& readers) {
  if (!entry["cloth"].IsDefined()) return readers.all();
  std::string name;
  inside("cloth", [&] { into(name)(entry["cloth"]); });
  return readers.of(name);
}

MotionEntry read_entry(const YAML::Node& node, PointReaders& readers) {
  if (!node.IsMap()) throw InvalidValue({}, describe(node), "a map");
  std::vector<std::string> known;
  for (Kind& kind : kinds()) {
    known.push_back(kind.key);
    if (!node[kind.key].IsDefined()) continue;
    MotionEntry entry{0, std::move(kind.action)};
    const bool has_points = kind.key == "attach" || kind.key == "detach";
    PointReader& points = has_points ? reader_for(node, readers) : readers.all();
    std::vector<Field> all =
        std::visit([&](auto& action) { return fields(action, points); }, entry.action);
    if (has_points) all.push_back({"cloth", [](const YAML::Node&) {}});  // read first
    if (has_points && node["cloth"].IsDefined() && !node["points"].IsDefined()) {
      throw InvalidValue({"cloth"}, describe(node["cloth"]), "none without points");
    }
    all.push_back({kind.key, [&](const YAML::Node& value) { kind.read(value, entry.action); }});
    if (kind.key != "file") all.push_back({"time", into(entry.time)});
    read_map(node, all);
    if (kind.key == "frame" && !node["position"].IsDefined()) {
      throw InvalidValue({"position"}, "nothing", "a list of three numbers");
    }
    if (node["rpy"].IsDefined() && node["orientation"].IsDefined()) {
      throw InvalidValue({"rpy"}, "an orientation again", "rpy or orientation");
    }
    return entry;
  }
  throw InvalidValue({}, "none of them", "one of the keys " + join(known));
}

}  // namespace

std::vector<MotionEntry> read_motions(const YAML::Node& node, const ClothSpec& cloth) {
  PointReaders readers(cloth);
  std::vector<MotionEntry> motions;
  read_list(node, [&](const YAML::Node& item) { motions.push_back(read_entry(item, readers)); });
  return motions;
}

}  // namespace clothsim
