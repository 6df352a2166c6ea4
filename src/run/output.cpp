#include "clothsim/run/output.h"

#include <array>
#include <cstdint>
#include <cstdio>
#include <cstring>
#include <utility>

#include "clothsim/model/checks.h"

namespace clothsim {
namespace {

template <class Number>
void append_bytes(Number value, std::string& bytes) {
  std::array<char, sizeof(Number)> raw;
  std::memcpy(raw.data(), &value, sizeof(Number));
  bytes.append(raw.data(), raw.size());
}

std::string rows_npy(const std::vector<std::array<int, 3>>& rows) {
  std::vector<std::int32_t> values;
  for (const std::array<int, 3>& row : rows) values.insert(values.end(), row.begin(), row.end());
  return to_npy({rows.size(), 3}, values);
}

NumberArray uv_array(const Cloth& cloth) {
  NumberArray array{{static_cast<std::size_t>(cloth.num_points()), 2}, {}};
  for (Eigen::Index i = 0; i < cloth.uv.rows(); ++i) {
    array.values.insert(array.values.end(), {cloth.uv(i, 0), cloth.uv(i, 1)});
  }
  return array;
}

std::string springs_npy(const Cloth& cloth) {
  std::vector<std::array<int, 3>> springs;
  for (const SpringRun& run : cloth.springs) {
    for (int point = run.first; point < run.first + run.count; ++point)
      springs.push_back({point, point + run.offset, static_cast<int>(run.family)});
  }
  return rows_npy(springs);
}

/// N x 3 from an array [N, 3], or from the last item of [F, N, 3].
Points last_points(const std::map<std::string, NumberArray>& arrays, const std::string& name) {
  const auto found = arrays.find(name);
  if (found == arrays.end()) throw InvalidValue({name}, "nothing", "an array [N, 3] or [F, N, 3]");
  const std::vector<std::size_t>& shape = found->second.shape;
  const bool is_list = shape.size() == 2 || (shape.size() == 3 && shape[0] > 0);
  if (!is_list || shape.back() != 3) {
    throw InvalidValue({name}, "an array of another shape", "[N, 3] or [F, N, 3]");
  }
  using Rows = Eigen::Matrix<double, Eigen::Dynamic, 3, Eigen::RowMajor>;
  const auto count = static_cast<Eigen::Index>(shape[shape.size() - 2]);
  const std::vector<double>& values = found->second.values;
  return Eigen::Map<const Rows>(values.data() + values.size() - 3 * static_cast<std::size_t>(count),
                                count, 3);
}

/// Numbers of a pose in an array: its position and its quaternion.
enum : std::size_t { pose_numbers = 7 };

NumberArray pose_array(const std::vector<Pose>& poses) {
  NumberArray array{{poses.size(), pose_numbers}, {}};
  for (const Pose& pose : poses) {
    const Eigen::Vector4d q = pose.orientation.coeffs();  // x, y, z, w
    array.values.insert(array.values.end(), pose.position.begin(), pose.position.end());
    array.values.insert(array.values.end(), q.begin(), q.end());
  }
  return array;
}

std::vector<Pose> to_poses(const NumberArray& array) {
  if (array.shape.size() != 2 || array.shape[1] != pose_numbers) {
    throw InvalidValue({"colliders"}, "an array of another shape", "[C, 7]");
  }
  std::vector<Pose> poses(array.shape[0]);
  const double* numbers = array.values.data();
  for (Pose& pose : poses) {
    pose.position = Eigen::Map<const Vector3>(numbers);
    pose.orientation.coeffs() = Eigen::Map<const Eigen::Vector4d>(numbers + 3);
    numbers += pose_numbers;
  }
  return poses;
}

}  // namespace

std::string to_csv(const State& state) {
  std::string text = "x,y,z,vx,vy,vz\n";
  std::array<char, 200> line;
  for (Eigen::Index i = 0; i < state.positions.rows(); ++i) {
    const auto x = state.positions.row(i);
    const auto v = state.velocities.row(i);
    const int length =
        std::snprintf(line.data(), line.size(), "%.17g,%.17g,%.17g,%.17g,%.17g,%.17g\n", x[0], x[1],
                      x[2], v[0], v[1], v[2]);
    text.append(line.data(), static_cast<size_t>(length));
  }
  return text;
}

std::string to_ply(const Cloth& cloth, const Points& positions) {
  constexpr bool little = __BYTE_ORDER__ == __ORDER_LITTLE_ENDIAN__;
  std::string ply = std::string("ply\nformat ") +
                    (little ? "binary_little_endian" : "binary_big_endian") +
                    " 1.0\nelement vertex " + std::to_string(positions.rows()) +
                    "\nproperty double x\nproperty double y\nproperty double z\nelement face " +
                    std::to_string(cloth.triangles.size()) +
                    "\nproperty list uchar int vertex_indices\nend_header\n";
  for (Eigen::Index i = 0; i < positions.rows(); ++i) {
    for (int axis = 0; axis < 3; ++axis) append_bytes(positions(i, axis), ply);
  }
  for (const auto& triangle : cloth.triangles) {
    append_bytes<std::uint8_t>(3, ply);
    for (const int point : triangle) append_bytes<std::int32_t>(point, ply);
  }
  return ply;
}

StateFile state_file(const Simulator& simulator) {
  StateFile file{simulator.state(), simulator.memory(), {}};
  for (std::size_t i = 0; i < simulator.scene().colliders.size(); ++i) {
    file.colliders.push_back(simulator.collider_pose(static_cast<int>(i)));
  }
  return file;
}

void write_state(const std::filesystem::path& path, const StateFile& file) {
  write_npz(path, {{"positions", to_npy(to_array(file.state.positions))},
                   {"velocities", to_npy(to_array(file.state.velocities))},
                   {"time", to_npy(NumberArray{{}, {file.state.time}})},
                   {"memory", to_npy(NumberArray{{file.memory.size()}, file.memory})},
                   {"colliders", to_npy(pose_array(file.colliders))}});
}

StateFile read_state(const std::filesystem::path& path) {
  StateFile file;
  inside(path.string(), [&] {
    const std::map<std::string, NumberArray> arrays = read_npz(path);
    file.state.positions = last_points(arrays, "positions");
    file.state.velocities = last_points(arrays, "velocities");
    for (const char* name : {"time", "times"}) {
      const auto time = arrays.find(name);
      if (time != arrays.end() && !time->second.values.empty())
        file.state.time = time->second.values.back();
    }
    const auto memory = arrays.find("memory");
    if (memory != arrays.end()) file.memory = memory->second.values;
    const auto colliders = arrays.find("colliders");
    if (colliders != arrays.end()) file.colliders = to_poses(colliders->second);
  });
  return file;
}

FramesFile::FramesFile(std::filesystem::path path, const Cloth& cloth)
    : path_(std::move(path)),
      topology_{{"triangles", rows_npy(cloth.triangles)},
                {"springs", springs_npy(cloth)},
                {"uv", to_npy(uv_array(cloth))},
                {"pinned", to_npy({cloth.pinned.size()}, cloth.pinned)}},
      positions_(path_.string() + ".positions.part",
                 {static_cast<std::size_t>(cloth.num_points()), 3}),
      velocities_(path_.string() + ".velocities.part",
                  {static_cast<std::size_t>(cloth.num_points()), 3}),
      times_(path_.string() + ".times.part", {}) {}

void FramesFile::append(const State& state) {
  positions_.append(to_array(state.positions).values);
  velocities_.append(to_array(state.velocities).values);
  times_.append({state.time});
}

void FramesFile::finish() {
  for (GrowingNpy* array : {&positions_, &velocities_, &times_}) array->flush();
  write_npz(path_, topology_,
            {{"positions", positions_.path()},
             {"velocities", velocities_.path()},
             {"times", times_.path()}});
}

}  // namespace clothsim
