#include "clothsim/dynamics/springs.h"

#include <array>
#include <set>
#include <utility>

#include "verification/testing.h"

namespace clothsim::springs_test {
namespace {

using namespace test;

TEST(Springs, BandsHoldEverySpringOnceAndNothingElse) {
  ClothSpec spec = square_spec(7);
  spec.columns = 5;
  for (const std::array<bool, 3>& families :
       {std::array<bool, 3>{true, true, true}, std::array<bool, 3>{false, true, false}}) {
    spec.material.springs = families;
    const Cloth cloth = make_grid(spec);
    std::multiset<std::pair<int, int>> expected;
    for_each_spring(cloth, [&](const SpringRun&, int a, int b) { expected.insert({a, b}); });

    std::multiset<std::pair<int, int>> found;
    int bands = 0;
    for_each_band(cloth, [&](const SpringBand& band) {
      ++bands;
      std::vector<bool> is_spring(static_cast<std::size_t>(band.count()), true);
      band.for_each_gap([&](int from, int to) {
        for (int i = from; i < to; ++i) is_spring[static_cast<std::size_t>(i)] = false;
      });
      for (int i = 0; i < band.count(); ++i) {
        if (!is_spring[static_cast<std::size_t>(i)]) continue;
        found.insert({band.first() + i, band.first() + i + band.begin->offset});
      }
      EXPECT_LE(band.first() + band.count() + band.begin->offset, cloth.num_points());
    });
    EXPECT_EQ(found, expected);
    EXPECT_EQ(bands, families[0] ? 6 : 2);
  }
}

TEST(Springs, NoSpringsNoBands) {
  ClothSpec spec = square_spec(3);
  spec.material.springs = {false, false, false};
  for_each_band(make_grid(spec), [](const SpringBand&) { FAIL(); });
}

}  // namespace
}  // namespace clothsim::springs_test
