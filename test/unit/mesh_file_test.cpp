#include "clothsim/shapes/mesh_file.h"

#include <gtest/gtest.h>

#include <fstream>

#include "clothsim/model/errors.h"
#include "clothsim/model/resource.h"
#include "meshes.h"
#include "temporary_folder.h"

namespace clothsim::mesh_file_test {
namespace {

namespace fs = std::filesystem;
using namespace test;

const Vector3 unit(1, 1, 1);

std::string refusal(const fs::path& path) {
  try {
    read_mesh_file(path, "", unit);
  } catch (const InvalidValue& error) {
    return error.what();
  }
  return "accepted";
}

void expect_refusal(const fs::path& path, const std::string& words) {
  EXPECT_NE(refusal(path).find(words), std::string::npos) << refusal(path);
}

/// A cube of side 2 with a unit and an up axis of its own.
void write_dae(const fs::path& path, const std::string& axis, const std::string& metres) {
  std::ofstream file(path);
  file << R"(<?xml version="1.0"?>
<COLLADA xmlns="http://www.collada.org/2005/11/COLLADASchema" version="1.4.1">
<asset><created>2000-01-01T00:00:00</created><modified>2000-01-01T00:00:00</modified><unit meter=")"
       << metres << "\"/><up_axis>" << axis << R"(</up_axis></asset>
<library_geometries><geometry id="g"><mesh>
<source id="p"><float_array id="a" count="24">)";
  for (int i = 0; i < 8; ++i) {
    file << (i & 1 ? 1 : -1) << ' ' << (i & 2 ? 2 : -2) << ' ' << (i & 4 ? 3 : -3) << ' ';
  }
  file << R"(</float_array><technique_common><accessor source="#a" count="8" stride="3">
<param name="X" type="float"/><param name="Y" type="float"/><param name="Z" type="float"/>
</accessor></technique_common></source>
<vertices id="v"><input semantic="POSITION" source="#p"/></vertices>
<triangles count="12"><input semantic="VERTEX" source="#v" offset="0"/><p>
0 2 1 1 2 3 4 5 6 5 7 6 0 1 4 1 5 4 2 6 3 3 6 7 0 4 2 2 4 6 1 3 5 3 7 5</p></triangles>
</mesh></geometry></library_geometries>
<library_visual_scenes><visual_scene id="s"><node id="n"><instance_geometry url="#g"/></node>
</visual_scene></library_visual_scenes>
<scene><instance_visual_scene url="#s"/></scene></COLLADA>)";
}

TEST(MeshFile, OfEachKindIsTheSameSolid) {
  const TemporaryFolder folder("mesh_file");
  const TriangleSoup soup = torus_soup(0.1, 0.03, 24, 12);
  const Solid given(soup);
  write_obj(folder.path() / "a.obj", soup);
  write_stl(folder.path() / "a.STL", soup);
  for (const char* name : {"a.obj", "a.STL"}) {
    const auto file = read_mesh_file(folder.path() / name, "uri", {1, 2, -1});
    EXPECT_EQ(file->solid.triangles().size(), soup.triangles.size());
    EXPECT_EQ(file->solid.vertices().size(), soup.vertices.size());
    EXPECT_EQ(file->uri, "uri");
    // Mirrored and stretched, and not inside out.
    EXPECT_NEAR(file->solid.box().max().y(), 2 * given.box().max().y(), 1e-6);
    EXPECT_LT(file->solid.distance({0.1, 0, 0}).first, 0);
  }
  EXPECT_EQ(read_mesh_file(folder.path() / "a.obj", "uri", unit),
            read_mesh_file(folder.path() / "a.obj", "uri", unit))
      << "twice in memory";
}

TEST(MeshFile, OfADaeTheUnitCountsAndTheUpAxisDoesNot) {
  const TemporaryFolder folder("mesh_file");
  for (const char* axis : {"Z_UP", "Y_UP", "X_UP"}) {
    write_dae(folder.path() / "a.dae", axis, "0.01");
    const TriangleSoup soup = read_triangles(folder.path() / "a.dae", unit);
    Box box;
    for (const Vector3& p : soup.vertices) box.extend(p);
    EXPECT_LT((box.max() - Vector3(0.01, 0.02, 0.03)).norm(), 1e-7) << axis;
  }
}

TEST(MeshFile, RefusesWhatIsNone) {
  const TemporaryFolder folder("mesh_file");
  const fs::path at = folder.path();
  expect_refusal(at / "none.stl", "No such file");
  expect_refusal(at / "a.txt", "ends in .stl, .obj or .dae");
  expect_refusal(at, "ends in .stl");
  fs::create_directory(at / "folder.stl");
  expect_refusal(at / "folder.stl", "mesh file");
  std::ofstream(at / "empty.stl");
  std::ofstream(at / "rubbish.stl") << std::string(300, '\xff');
  std::ofstream(at / "rubbish.dae") << "<COLLADA>";
  std::ofstream(at / "points.obj") << "v 0 0 0\nv 1 0 0\n";
  for (const char* name : {"empty.stl", "rubbish.stl", "rubbish.dae", "points.obj"}) {
    EXPECT_NE(refusal(at / name), "accepted") << name;
  }
  TriangleSoup soup = box_soup({1, 1, 1});
  soup.triangles.pop_back();
  write_obj(at / "open.obj", soup);
  expect_refusal(at / "open.obj", "a hole at the edge from");
  write_obj(at / "wide.obj", box_soup({1e7, 1, 1}));
  expect_refusal(at / "wide.obj", "vertex");
}

TEST(Resource, IsFoundByPackageByFileOrFromTheFolderOn) {
  const TemporaryFolder folder("resource");
  const fs::path package = folder.path() / "deep" / "in" / "robot";
  fs::create_directories(package / "meshes");
  std::ofstream(package / "package.xml") << "<package><name> my_robot </name></package>";
  ::setenv("ROS_PACKAGE_PATH", ("/nowhere:" + folder.path().string()).c_str(), 1);
  const std::string name = "package://my_robot/meshes/a.stl";
  EXPECT_EQ(find_resource(name, "/else"), package / "meshes/a.stl");
  EXPECT_EQ(uri_of(name, package / "meshes/a.stl"), name);
  EXPECT_EQ(find_resource("file:///a/b.stl", "/else"), "/a/b.stl");
  EXPECT_EQ(find_resource("b.stl", "/else"), "/else/b.stl");
  EXPECT_EQ(find_resource("/a/b.stl", "/else"), "/a/b.stl");
  EXPECT_EQ(uri_of("b.stl", "/else/b.stl"), "file:///else/b.stl");
  // Blanks and other special characters, plain or escaped; the uri has them escaped.
  for (const char* each : {"my meshes/a%20.stl", "my%20meshes/a%2520.stl"}) {
    const bool is_plain = each[2] == ' ';
    const std::string path = is_plain ? "my meshes/a .stl" : "my meshes/a%20.stl";
    const std::string escaped = is_plain ? "my%20meshes/a%20.stl" : "my%20meshes/a%2520.stl";
    EXPECT_EQ(find_resource("file:///" + std::string(each), "/else"), '/' + path);
    EXPECT_EQ(find_resource("package://my_robot/" + std::string(each), "/else"), package / path);
    EXPECT_EQ(uri_of("package://my_robot/" + std::string(each), ""),
              "package://my_robot/" + escaped);
    EXPECT_EQ(uri_of("file:///" + std::string(each), '/' + path), "file:///" + escaped);
  }
  EXPECT_EQ(find_resource("my meshes/a%20.stl", "/else"), "/else/my meshes/a%20.stl") << "no URI";
  for (const char* bad :
       {"package://robot/a.stl", "package://", "package:///a", "http://a/b.stl"}) {
    EXPECT_THROW(find_resource(bad, "/"), InvalidValue) << bad;
  }
  ::unsetenv("ROS_PACKAGE_PATH");
}

TEST(MeshFile, WithShellsThatOverlapIsSeveralSolids) {
  const TemporaryFolder folder("shells");
  const std::string path = (folder.path() / "two.obj").string();
  write_obj(path, together({box_soup({1, 1, 1}), moved(box_soup({1, 1, 1}), {0.4, 0.3, 0.2})}));
  const auto files = read_mesh_files(path, "two", {2, 2, 2});
  ASSERT_EQ(files.size(), 2u);
  EXPECT_NEAR(files[0]->solid.distance({0.9, 0.5, 0.1}).first, -0.1, 1e-6);
  EXPECT_NEAR(files[1]->solid.distance({1.7, 0.5, 0.5}).first, -0.1, 1e-6);
  EXPECT_EQ(read_mesh_files(path, "two", {2, 2, 2}), files) << "shared";
  try {
    read_mesh_file(path, "two", {2, 2, 2});
    FAIL();
  } catch (const InvalidValue& error) {
    EXPECT_NE(std::string(error.what()).find("shells that touch or overlap"), std::string::npos);
  }
}

}  // namespace
}  // namespace clothsim::mesh_file_test
