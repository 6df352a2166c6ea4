// A scene's cloth from a mesh file.

#include <gtest/gtest.h>

#include <fstream>

#include "clothsim/dynamics/energy.h"
#include "clothsim/model/make_cloth.h"
#include "says.h"
#include "scene_text.h"
#include "temporary_folder.h"

namespace clothsim::cloth_mesh_yaml_test {
namespace {

class ClothMeshYaml : public ::testing::Test {
 protected:
  void SetUp() override {
    std::ofstream(folder_.path() / "square.obj")
        << "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf 1 2 3\nf 1 3 4\n";
  }

  void write(const std::string& name, const std::string& text) {
    std::ofstream(folder_.path() / name) << text;
  }
  /// A scene whose cloth has the mesh and these other keys.
  Scene read(const std::string& mesh, const std::string& others = "fabric: felt") const {
    SceneSources sources;
    sources.folder = folder_.path();
    return read_scene(YAML::Load("cloth: {mesh: {" + mesh + "}, " + others + "}"), sources);
  }
  std::string mistake(const std::string& mesh, const std::string& others = "fabric: felt") const {
    try {
      read(mesh, others);
    } catch (const InvalidValue& error) {
      return error.what();
    }
    return "accepted";
  }

  test::TemporaryFolder folder_{"cloth_mesh"};
};

TEST_F(ClothMeshYaml, IsPlacedAndScaled) {
  const Scene scene = read(
      "file: square.obj, scale: [0.5, 2, 1], "
      "pose: {xyz: [1, 2, 3], rpy: [1.5707963267948966, 0, 0]}");
  const Points& x = scene.cloth.mesh->positions;
  EXPECT_LT((row(x, 2) - Vector3(1.5, 2, 5)).norm(), 1e-12);
  EXPECT_EQ(scene.cloth.columns, 4);
  EXPECT_EQ(scene.cloth.rows, 1);
}

TEST_F(ClothMeshYaml, NamesPointsByNumberAndPlace) {
  const Scene scene = read("file: square.obj",
                           "fabric: felt, pinned: [1, {point: 2, frame: hand}, {near: [0, 2, 0]}]");
  std::vector<int> pinned;
  for (const Pin& pin : scene.cloth.pinned) pinned.push_back(pin.column);
  EXPECT_EQ(pinned, (std::vector<int>{1, 2, 3}));
  EXPECT_EQ(make_cloth(scene.cloth).inv_mass[3], 0);

  EXPECT_TRUE(says(mistake("file: square.obj", "fabric: felt, pinned: [4]"),
                   "cloth.pinned.0: got 4 ... 0 to 3"));
  EXPECT_TRUE(says(mistake("file: square.obj", "fabric: felt, pinned: [[0, 0]]"),
                   "cloth.pinned.0: got [0, 0] ... number of a point"));
}

TEST_F(ClothMeshYaml, IsFlatAtRestOrAsItIs) {
  write("bent.obj", "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 1\nf 1 2 3\nf 1 3 4\n");
  const auto energy_at_start = [](const ClothSpec& spec) {
    return elastic_energy(make_cloth(spec), spec.mesh->positions);
  };
  EXPECT_GT(energy_at_start(read("file: bent.obj").cloth), 1e-6);
  EXPECT_GT(energy_at_start(read("file: bent.obj, rest: flat").cloth), 1e-6);
  EXPECT_LT(energy_at_start(read("file: bent.obj, rest: as_is").cloth), 1e-20);
  const Scene placed = read(
      "file: bent.obj, rest: as_is, scale: [-1, 1, 1], pose: {xyz: [1, 2, 3], rpy: [1, 2, 3]}");
  EXPECT_LT(energy_at_start(placed.cloth), 1e-20);
  EXPECT_TRUE(
      says(mistake("file: bent.obj, rest: folded"), "cloth.mesh.rest: got folded ... as_is"));

  // Each of several cloths by itself.
  const auto joined = [&](const std::string& one, const std::string& other) {
    SceneSources sources;
    sources.folder = folder_.path();
    const std::string grid =
        "{name: grid, fabric: felt, columns: 3, rows: 3, self_collision: false}";
    const auto bent = [](const std::string& name, const std::string& rest) {
      return "{name: " + name +
             ", fabric: felt, self_collision: false, mesh: {file: bent.obj, rest: " + rest +
             ", pose: {xyz: [" + (name == "one" ? "5" : "-5") + ", 0, 0]}}}";
    };
    return energy_at_start(read_scene(YAML::Load("cloths: [" + bent("one", one) + ", " + grid +
                                                 ", " + bent("other", other) + "]"),
                                      sources)
                               .cloth);
  };
  const double bent = joined("as_is", "flat");
  EXPECT_LT(joined("as_is", "as_is"), 1e-20);
  EXPECT_GT(bent, 1e-6);
  EXPECT_NEAR(joined("flat", "as_is"), bent, 1e-12 * bent);
  EXPECT_NEAR(joined("flat", "flat"), 2 * bent, 1e-12 * bent);
}

TEST_F(ClothMeshYaml, RefusesMistakes) {
  EXPECT_TRUE(says(mistake("scale: 1"), "cloth.mesh.file: got nothing"));
  EXPECT_TRUE(says(mistake("file: none.obj"), "cloth.mesh.file: got ... none.obj"));
  EXPECT_TRUE(says(mistake("file: square.txt"), "cloth.mesh.file: got ... .ply"));
  EXPECT_TRUE(says(mistake("file: square.obj, scale: 0"), "cloth.mesh.scale.0: got 0"));
  EXPECT_TRUE(says(mistake("file: square.obj, warp: [0, 0, 0]"), "cloth.mesh.warp: got"));
  EXPECT_TRUE(says(mistake("file: square.obj, lengths: mine"), "cloth.mesh.lengths: got mine"));
  EXPECT_TRUE(says(mistake("file: square.obj, lengths: uv"), "cloth.mesh.file: got no texture"));
  EXPECT_TRUE(says(mistake("file: square.obj, lengths: uv, warp: [0, 1, 0]"),
                   "cloth.mesh.warp: got [0, 1, 0] ... none with lengths: uv"));
  EXPECT_TRUE(
      says(mistake("file: square.obj, pose: {xyz: [1e9, 0, 0]}"), "cloth.mesh.pose.xyz.0: got"));
  EXPECT_TRUE(says(mistake("file: square.obj", "ks: 5"), "cloth.fabric: got none"));
  EXPECT_TRUE(says(mistake("file: square.obj", "fabric: felt, columns: 5"),
                   "cloth.columns: got 5 ... none with a mesh"));
  EXPECT_TRUE(says(mistake("file: square.obj", "fabric: felt, origin: [0, 0, 0]"),
                   "cloth.origin: got ... mesh.pose"));
}

TEST_F(ClothMeshYaml, RefusesBrokenFiles) {
  const std::string corners = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\n";
  const std::pair<std::string, const char*> files[] = {
      {"", "cloth.mesh.file: got"},
      {"nonsense", "cloth.mesh.file: got"},
      {"v 0 0 0\nv 1 0 0\nl 1 2\n", "cloth.mesh.file: got"},
      {"f 1 2 3\n", "cloth.mesh.file: got"},
      {"v 0 0 0\nv 1 0 0\nv 1 1 0\nf 1 2 9\n", "cloth.mesh.file: got"},
      {"v 0 0 0\nv nan 0 0\nv 1 1 0\nf 1 2 3\n", "cloth.mesh.file"},
      {"v 0 0 0\nv 1e30 0 0\nv 1 1 0\nf 1 2 3\n", "cloth.mesh.file"},
      {corners + "f 1 1 2\n", "cloth.mesh.file: got"},
      {corners + "v 0.5 0 0\nf 1 2 5\n", "cloth.mesh.file: got triangle 0 ... degrees"},
      {corners + "v 0.0000001 0 0\nv 0.00000005 0.0000001 0\nf 1 5 6\n",
       "cloth.mesh.file: got triangle 0 ... edge of"},
      {corners + "v 0.5 0 1\nf 1 2 3\nf 1 2 4\nf 1 2 5\n", "cloth.mesh.file: got an edge of three"},
      {corners + "v 0.2 0.1 -1\nv 0.3 0.1 1\nv 0.4 0.1 1\nf 1 2 3\nf 5 6 7\n",
       "cloth.mesh.file: got triangle 0 ... through triangle 1"}};
  for (const auto& [text, message] : files) {
    write("broken.obj", text);
    EXPECT_TRUE(says(mistake("file: broken.obj"), message)) << text;
  }
  write("broken.ply", "ply\nformat ascii 1.0\nelement vertex 9999999999\n");
  EXPECT_TRUE(says(mistake("file: broken.ply"), "cloth.mesh.file: got"));
  const std::string header =
      "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\n"
      "property float z\nelement face 1\nproperty list uchar int vertex_indices\nend_header\n"
      "0 0 0\n1 0 0\n1 1 0\n0 1 0\n";
  for (const char* face : {"3 0 2 900000000\n", "4 0 1 2 900000000\n", "3 0 2 7\n", "3 0 2 -1\n"}) {
    write("broken.ply", header + face);
    EXPECT_TRUE(says(mistake("file: broken.ply"), "cloth.mesh.file: got vertex")) << face;
  }
  write("good.ply", header + "3 0 1 2\n");
  EXPECT_EQ(mistake("file: good.ply"), "accepted");
  write("broken.stl", "solid x\nfacet normal 0 0 1\nouter loop\n");
  EXPECT_TRUE(says(mistake("file: broken.stl"), "cloth.mesh.file: got"));
}

}  // namespace
}  // namespace clothsim::cloth_mesh_yaml_test
