#include "clothsim/ros/ignored_parameters.h"

#include <gtest/gtest.h>

#include "says.h"

namespace clothsim_ros::ignored_parameters_test {
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
  const std::string all = "scene, camera, paused, realtime_factor";
  const auto told = [](const std::string& name) {
    const std::vector<std::string> messages = ignored({{name, "1"}}, {{name, "1"}});
    EXPECT_EQ(messages.size(), 1u) << name;
    return messages.empty() ? "" : messages[0];
  };
  const auto says_of = [&](const std::string& name, const std::string& reason) {
    return clothsim::says(told(name), "/cloth/" + name + ": got ... unknown ... " + all + reason);
  };
  EXPECT_TRUE(says_of("realtime_facto", " ... realtime_factor?"));
  EXPECT_TRUE(says_of("pause", " ... paused?"));
  EXPECT_TRUE(says_of("kss", " ... ks? ... ~scene or ~camera"));
  EXPECT_TRUE(says_of("light/intensty", " ... light/intensity? ... ~scene or ~camera"));
  EXPECT_EQ(told("gripper"), "/cloth/gripper: got an unknown parameter, expected one of " + all)
      << "an example of a whole message";
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
  EXPECT_TRUE(clothsim::says(messages[0],
                             "/cloth/n10000, n10001, n10002 ... 19997 more: got unknown ... "
                             "scene, camera, paused, realtime_factor"));
  EXPECT_EQ(messages[1].substr(0, 10), "/cloth/ks:");
  given.clear();
  for (int i = 0; i < 5; ++i) given["n" + std::to_string(i)] = "1";
  EXPECT_EQ(ignored(given, given).size(), 5u);
}

TEST(IgnoredParameters, LiveValuesThatTheSceneOverrides) {
  const std::vector<std::string> messages =
      ignored({{"ks", "123"}, {"density", "150"}}, {{"ks", "5000"}, {"density", "150"}});
  ASSERT_EQ(messages.size(), 1u);
  EXPECT_TRUE(
      clothsim::says(messages[0], "/cloth/ks: got 123 ... ~scene or ~camera ... 5000 holds"));
}

}  // namespace
}  // namespace clothsim_ros::ignored_parameters_test
