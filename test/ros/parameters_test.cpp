#include "clothsim/ros/parameters.h"

#include <gtest/gtest.h>

#include <cstdlib>
#include <new>

namespace {
long allocations = 0;
}

void* operator new(std::size_t size) {
  ++allocations;
  if (void* memory = std::malloc(size)) return memory;
  throw std::bad_alloc();
}

void operator delete(void* memory) noexcept { std::free(memory); }
void operator delete(void* memory, std::size_t) noexcept { std::free(memory); }

namespace clothsim_ros::parameters_test {
namespace {

XmlRpc::XmlRpcValue make_map(int keys) {
  XmlRpc::XmlRpcValue map;
  for (int i = 0; i < keys; ++i) map["a_key_too_long_for_a_small_string_" + std::to_string(i)] = i;
  return map;
}

TEST(Parameters, MapsKeepTheirKeys) {
  const YAML::Node map = to_yaml(make_map(3));
  ASSERT_EQ(map.size(), 3u);
  EXPECT_EQ(map["a_key_too_long_for_a_small_string_2"].as<int>(), 2);
}

/// A comparison of keys takes an allocation: a linear search for each key makes them quadratic.
TEST(Parameters, MapsAreReadInLinearTime) {
  const auto count = [](int keys) {
    const XmlRpc::XmlRpcValue map = make_map(keys);
    const long before = allocations;
    to_yaml(map);
    return static_cast<double>(allocations - before);
  };
  EXPECT_LT(count(2000), 2.1 * count(1000));
}

}  // namespace
}  // namespace clothsim_ros::parameters_test
