// Cost of a change of many values of a scene, counted in allocations, which each step of it takes.

#include <gtest/gtest.h>

#include <atomic>
#include <cstdlib>
#include <new>
#include <string>
#include <vector>

#include "clothsim/scene/scene_yaml.h"

namespace {

std::atomic<long long> allocations{0};

}  // namespace

void* operator new(std::size_t size, const std::nothrow_t&) noexcept {
  ++allocations;
  return std::malloc(size);
}
void* operator new(std::size_t size) {
  if (void* place = operator new(size, std::nothrow)) return place;
  throw std::bad_alloc();
}
void operator delete(void* place) noexcept { std::free(place); }
void operator delete(void* place, std::size_t) noexcept { std::free(place); }

namespace clothsim::override_cost_test {
namespace {

/// Allocations to change `options` of `pins` pins.
long long cost(int pins, int options) {
  std::string text = "cloth: {pinned: [[0, 0]";
  for (int i = 1; i < pins; ++i) text += ", [1, 2]";
  YAML::Node root = YAML::Load(text + "]}");
  std::vector<std::string> assignments;
  for (int i = 0; i < options; ++i) {
    assignments.push_back("cloth.pinned." + std::to_string(i) + ".0=3");
  }
  const long long before = allocations;
  override_values(root, assignments);
  EXPECT_EQ(root["cloth"]["pinned"][options - 1][0].Scalar(), "3");
  return allocations - before;
}

TEST(OverrideCost, GrowsWithTheSceneAndTheOptionsNotWithTheirProduct) {
  const long long small = cost(500, 100), many = cost(500, 400);
  const long long large = cost(2000, 100), both = cost(2000, 400);
  const long long sum = many + large - small;  // if the costs add up
  EXPECT_LT(both, sum + sum / 10);
}

}  // namespace
}  // namespace clothsim::override_cost_test
