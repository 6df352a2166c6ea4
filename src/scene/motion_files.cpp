#include "clothsim/scene/motion_files.h"

#include <array>
#include <charconv>
#include <fstream>
#include <iterator>

#include "clothsim/model/checks.h"
#include "clothsim/model/npz.h"
#include "clothsim/scene/scene.h"

namespace clothsim {
namespace {

/// As many as the largest allowed file has with the shortest lines.
constexpr std::size_t max_key_frames = max_file_size / std::size("0,0,0,0");

/// Time, position and quaternion x, y, z, w, row by row.
using Row = std::array<double, 8>;

constexpr const char* csv_header = "time,x,y,z";
constexpr const char* csv_header_turned = "time,x,y,z,qx,qy,qz,qw";

Row parse_line(const std::string& line, std::size_t columns) {
  Row row{0, 0, 0, 0, 0, 0, 0, 1};
  const char* at = line.data();
  const char* end = at + line.size();
  for (std::size_t i = 0; i < columns; ++i) {
    const auto [rest, error] = std::from_chars(at, end, row[i]);
    const bool is_last = i + 1 == columns;
    if (error != std::errc() || (is_last ? rest != end : rest == end || *rest != ',')) {
      throw InvalidValue({}, '"' + shortened(line, 60) + '"',
                         std::to_string(columns) + " numbers with commas between");
    }
    at = rest + 1;
  }
  return row;
}

std::vector<Row> read_csv(const std::filesystem::path& path) {
  std::ifstream file(path);
  std::string line;
  const auto next = [&] {
    if (!std::getline(file, line)) return false;
    if (!line.empty() && line.back() == '\r') line.pop_back();
    return true;
  };
  if (!next()) throw InvalidValue({}, "nothing that can be read", "a CSV file");
  const bool is_turned = line == csv_header_turned;
  if (!is_turned && line != csv_header) {
    throw InvalidValue({"1"}, '"' + shortened(line, 60) + '"',
                       std::string(csv_header) + " or " + csv_header_turned);
  }
  std::vector<Row> rows;
  while (rows.size() <= max_key_frames && next()) {
    inside(std::to_string(rows.size() + 2),
           [&] { rows.push_back(parse_line(line, is_turned ? std::tuple_size_v<Row> : 4)); });
  }
  return rows;
}

std::vector<Row> read_npz_rows(const std::filesystem::path& path) {
  const std::map<std::string, NumberArray> arrays = read_npz(path);
  const auto time = arrays.find("time");
  if (time == arrays.end() || time->second.shape.size() != 1) {
    throw InvalidValue({"time"}, "no list of numbers", "the time [s] of each key frame");
  }
  std::vector<Row> rows(time->second.values.size(), Row{0, 0, 0, 0, 0, 0, 0, 1});
  const auto fill = [&](const char* name, std::size_t first, std::size_t columns, bool must) {
    const auto found = arrays.find(name);
    if (found == arrays.end() && !must) return;
    const std::vector<std::size_t> shape{rows.size(), columns};
    if (found == arrays.end() || found->second.shape != shape) {
      throw InvalidValue({name}, found == arrays.end() ? "nothing" : "another shape",
                         std::to_string(rows.size()) + " x " + std::to_string(columns) +
                             " numbers, as many rows as times");
    }
    for (std::size_t i = 0; i < rows.size(); ++i) {
      for (std::size_t k = 0; k < columns; ++k)
        rows[i][first + k] = found->second.values[i * columns + k];
    }
  };
  for (std::size_t i = 0; i < rows.size(); ++i) rows[i][0] = time->second.values[i];
  fill("position", 1, 3, true);
  fill("orientation", 4, 4, false);
  return rows;
}

MotionEntry to_entry(const Row& row, const std::string& frame) {
  constexpr Range time_range{0, 1e6, "s"};
  check_range("time", row[0], time_range);
  const Eigen::Vector4d xyzw(row[4], row[5], row[6], row[7]);
  if (!(xyzw.stableNorm() >= written_rounding && xyzw.allFinite())) {
    throw InvalidValue({"orientation"}, "none", "a quaternion x, y, z, w");
  }
  KeyFrame key{frame, {}};
  key.target.pose.position = Vector3(row[1], row[2], row[3]);
  key.target.pose.orientation = Eigen::Quaterniond(Eigen::Vector4d(xyzw.stableNormalized()));
  check(key.target);
  return {row[0], key};
}

}  // namespace

std::vector<MotionEntry> read_key_frames(const std::filesystem::path& path,
                                         const std::string& frame) {
  std::vector<MotionEntry> entries;
  inside(path.string(), [&] {
    if (!std::filesystem::is_regular_file(path)) {
      throw InvalidValue({}, "no regular file", "a CSV or NPZ file of key frames");
    }
    const bool is_npz = path.extension() == ".npz";
    if (!is_npz && path.extension() != ".csv") {
      throw InvalidValue({}, "a file of another kind", "one that ends in .csv or .npz");
    }
    const std::vector<Row> rows = is_npz ? read_npz_rows(path) : read_csv(path);
    if (rows.empty() || rows.size() > max_key_frames) {
      throw InvalidValue({}, std::to_string(rows.size()) + " key frames or more",
                         "1 to " + std::to_string(max_key_frames));
    }
    for (std::size_t i = 0; i < rows.size(); ++i) {
      inside("key frame " + std::to_string(i),
             [&] { entries.push_back(to_entry(rows[i], frame)); });
    }
  });
  return entries;
}

}  // namespace clothsim
