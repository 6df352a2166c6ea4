#include "clothsim/ros/ignored_parameters.h"

#include <gtest/gtest.h>

namespace clothsim_ros {
namespace {

const KnownParameters known{{"scene", "camera", "paused", "realtime_factor"},
                            {"ks", "density", "light/intensity", "shading/cloth/ka"}};

std::vector<std::string> ignored(const ParameterTexts& given, const ParameterTexts& now) {
  return ignored_parameters("/cloth/", known, given, now);
}

TEST(IgnoredParameters, NoneOfThoseThatCount) {
  const ParameterTexts given{
      {"paused", "true"}, {"scene/cloth/kss", "5"}, {"ks", "5"}, {"light/intensity", "3"}};
  EXPECT_TRUE(ignored(given, given).empty());
}

TEST(IgnoredParameters, UnknownOnesWithTheNearestThatIsKnown) {
  const std::string all =
      "got an unknown parameter, expected one of scene, camera, paused, realtime_factor";
  const auto told = [](const std::string& name) { return ignored({{name, "1"}}, {{name, "1"}}); };
  using Messages = std::vector<std::string>;
  EXPECT_EQ(told("realtime_facto"),
            Messages{"/cloth/realtime_facto: " + all + "; did you mean realtime_factor?"});
  EXPECT_EQ(told("pause"), Messages{"/cloth/pause: " + all + "; did you mean paused?"});
  const std::string starts = "? It starts as ~scene or ~camera has it";
  EXPECT_EQ(told("kss"), Messages{"/cloth/kss: " + all + "; did you mean ks" + starts});
  EXPECT_EQ(told("light/intensty"),
            Messages{"/cloth/light/intensty: " + all + "; did you mean light/intensity" + starts});
  EXPECT_EQ(told("gripper"), Messages{"/cloth/gripper: " + all});
}

TEST(IgnoredParameters, AnUnknownNamespaceIsToldOnce) {
  const auto starts = [](const ParameterTexts& given) {
    std::vector<std::string> names;
    for (const std::string& message : ignored(given, given))
      names.push_back(message.substr(0, message.find(':')));
    return names;
  };
  using Names = std::vector<std::string>;
  EXPECT_EQ(starts({{"helper/gain", "1"}, {"helper/rate", "2"}}), Names{"/cloth/helper"});
  EXPECT_EQ(starts({{"shading/ball/ka", "1"}, {"shading/ball/kd", "2"}}),
            Names{"/cloth/shading/ball"});
}

TEST(IgnoredParameters, OfManyUnknownOnesOneLineNamesAFew) {
  ParameterTexts given{{"ks", "123"}};
  for (int i = 0; i < 20000; ++i) given["n" + std::to_string(10000 + i)] = "1";
  const std::vector<std::string> messages = ignored(given, {{"ks", "5000"}});
  ASSERT_EQ(messages.size(), 2u);
  EXPECT_EQ(messages[0],
            "/cloth/n10000, n10001, n10002 and 19997 more: got unknown parameters, expected one of "
            "scene, camera, paused, realtime_factor");
  EXPECT_EQ(messages[1].substr(0, 10), "/cloth/ks:");
  given.clear();
  for (int i = 0; i < 5; ++i) given["n" + std::to_string(i)] = "1";
  EXPECT_EQ(ignored(given, given).size(), 5u);
}

TEST(IgnoredParameters, LiveValuesThatTheSceneOverrides) {
  EXPECT_EQ(
      ignored({{"ks", "123"}, {"density", "150"}}, {{"ks", "5000"}, {"density", "150"}}),
      std::vector<std::string>{"/cloth/ks: got 123 before the start, expected it in ~scene or "
                               "~camera, whose 5000 holds"});
}

}  // namespace
}  // namespace clothsim_ros
