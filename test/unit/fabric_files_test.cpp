// Fabrics by name, from the shipped files and from a user's.

#include <filesystem>
#include <fstream>

#include "clothsim/model/package.h"
#include "says.h"
#include "scene_text.h"
#include "temporary_folder.h"
#include "verification/testing.h"

namespace clothsim::fabric_files_test {
namespace {

using test::run;
using test::TemporaryFolder;

constexpr const char* good_fabric = R"(
source: a test
date: "2026-01-02"
stretch_stiffness: [500, 400]
shear_stiffness: 20
bending_stiffness: 1.0e-05
internal_damping: [0, 0.001]
density: 0.2
thickness: 0.0005
friction: 0.4
drag: [1, 0.1]
damping: 0.5
strain_limit: 0.2
)";

/// A fabric's file of some text in a folder of its own.
class FabricFile {
 public:
  explicit FabricFile(const std::string& text) : folder_("fabric") {
    std::ofstream(path()) << text;
  }
  std::string path() const { return folder_.path() / "mine.yaml"; }
  std::string scene(const std::string& more = "") const {
    return "cloth: {fabric: " + path() + more + "}";
  }

 private:
  TemporaryFolder folder_;
};

std::vector<std::string> shipped_fabrics() {
  std::vector<std::string> names;
  for (const auto& file : std::filesystem::directory_iterator(package_folder("config/fabrics"))) {
    names.push_back(file.path().stem());
  }
  return names;
}

TEST(FabricFiles, EachShippedOneIsACompleteFabricThatHangs) {
  const std::vector<std::string> names = shipped_fabrics();
  EXPECT_GE(names.size(), 7u);
  for (const std::string& name : names) {
    SCOPED_TRACE(name);
    const Scene scene = read_scene(YAML::Load("cloth: {fabric: " + name +
                                              ", width: 0.4, height: 0.4, columns: 10, rows: 10, " +
                                              "pinned: [[0, 0], [9, 0]]}"));
    const Material& material = scene.cloth.material;
    ASSERT_TRUE(material.fabric);
    for (const int i : {0, 1}) {
      EXPECT_GT(material.fabric->stretch_stiffness[i], material.fabric->shear_stiffness);
      EXPECT_GT(material.fabric->bending_stiffness[i], 0);
      EXPECT_GT(material.fabric->internal_damping[i], 0);
    }
    EXPECT_GT(material.fabric->shear_stiffness, 0);
    EXPECT_LT(material.density, 0.5) << "no fabric";  // the default of Material is 150
    EXPECT_LT(scene.cloth.thickness, 0.005);          // half of a classic cloth's is 0.0095
    EXPECT_FALSE(material.strain_limit);
    Simulator simulator(scene);
    EXPECT_LT(run(simulator, 1).worst_stretch, 0.3);
  }
}

TEST(FabricFiles, OneOfYourOwnGivesAllValuesAndKeysBesideItOverride) {
  const FabricFile file(good_fabric);
  const ClothSpec cloth =
      read_scene(YAML::Load(file.scene(", density: 0.3, thickness: 0.001"))).cloth;
  const Fabric& fabric = cloth.material.fabric.value();
  EXPECT_EQ(fabric.stretch_stiffness, (std::array<double, 2>{500, 400}));
  EXPECT_EQ(fabric.shear_stiffness, 20);
  EXPECT_EQ(fabric.bending_stiffness, (std::array<double, 2>{1e-5, 1e-5}));
  EXPECT_EQ(fabric.internal_damping, (std::array<double, 2>{0, 0.001}));
  EXPECT_EQ(cloth.material.drag, (std::array<double, 2>{1, 0.1}));
  EXPECT_EQ(cloth.material.damping, 0.5);
  EXPECT_EQ(cloth.material.strain_limit, 0.2);
  EXPECT_EQ(cloth.friction, 0.4);
  EXPECT_EQ(cloth.material.density, 0.3);
  EXPECT_EQ(cloth.thickness, 0.001);
}

TEST(FabricFiles, MistakesAreToldByFileAndKey) {
  const auto told = [](const std::string& more, const std::string& message) {
    YAML::Node fabric = YAML::Load(good_fabric);
    for (const auto& entry : YAML::Load(more)) fabric[entry.first.as<std::string>()] = entry.second;
    const FabricFile file(YAML::Dump(fabric));
    EXPECT_TRUE(says(refusal(file.scene()), "cloth.fabric." + file.path() + '.' + message));
  };
  told("{source: ''}", "source: got \"\" ... empty");
  told("{date: [1]}", "date: got [1] ... text");
  told("{density: 0}", "density: got 0 ... least 1e-06 [kg/m^2]");
  told("{shear_stiffness: -1}", "shear_stiffness: got -1 ... least 0 [N/m]");
  told("{bending_stiffness: [1, .nan]}", "bending_stiffness.1: got .nan ... finite");
  told("{drag: -1}", "drag: got -1 ... least 0");
  EXPECT_TRUE(says(refusal("cloth: {fabric: tweed}"), "cloth.fabric: got \"tweed\" ... denim"));
  EXPECT_TRUE(says(refusal("cloth: {fabric: nowhere.yaml}"),
                   "cloth.fabric: got \"nowhere.yaml\" ... not there ... fabric"));
  const FabricFile file(good_fabric);
  const FabricFile without("{density: 0.2, source: none}");
  EXPECT_TRUE(says(refusal(without.scene()),
                   "cloth.fabric." + without.path() + ".date: got nothing ... values"));
  EXPECT_TRUE(says(refusal(file.scene(", ks: 5")), "cloth.ks: got 5 ... stretch_stiffness"));
}

TEST(FabricFiles, PathsBeginAtTheFolderOfTheScene) {
  const FabricFile file(good_fabric);
  const std::filesystem::path path = file.path();
  const YAML::Node scene = YAML::Load("cloth: {fabric: " + path.filename().string() + '}');
  EXPECT_EQ(read_scene(scene, {path.parent_path()}).cloth.material.fabric->shear_stiffness,
            read_scene(YAML::Load(file.scene())).cloth.material.fabric->shear_stiffness);
  EXPECT_THROW(read_scene(scene, {path.parent_path() / "other"}), InvalidValue);
}

}  // namespace
}  // namespace clothsim::fabric_files_test
