#include "clothsim/dynamics/cloth_watch.h"

#include <functional>

#include "verification/testing.h"

namespace clothsim::cloth_watch_test {
namespace {

using namespace test;

TEST(ClothWatch, NoticesWhateverAMethodKeeps) {
  const Cloth cloth = make_grid(square_spec(4));
  const std::vector<std::function<void(Cloth&)>> changes = {
      [](Cloth& c) { c.damping = 3; },
      [](Cloth& c) { c.mass[7] *= 2; },
      [](Cloth& c) { c.inv_mass[7] = 0; },
      [](Cloth& c) { c.springs.back().stiffness *= 2; },
      [](Cloth& c) { c.springs.back().rest_length *= 2; },
      [](Cloth& c) { c.springs.back().count -= 1; },
      [](Cloth& c) { c.springs.back().first += 1; },
      [](Cloth& c) { c.springs.back().offset -= 1; },
      [](Cloth& c) { c.springs.pop_back(); },
      [](Cloth& c) { c = make_grid(square_spec(5)); },
  };
  for (std::size_t i = 0; i < changes.size(); ++i) {
    ClothWatch watch;
    EXPECT_TRUE(watch.changed(cloth, 0.1));
    EXPECT_FALSE(watch.changed(cloth, 0.1));
    const Cloth copy = cloth;
    EXPECT_FALSE(watch.changed(copy, 0.1)) << "an equal cloth is the same";
    EXPECT_TRUE(watch.changed(cloth, 0.2)) << "the step";
    Cloth other = cloth;
    changes[i](other);
    EXPECT_TRUE(watch.changed(other, 0.2)) << "change " << i;
    EXPECT_FALSE(watch.changed(other, 0.2));
    EXPECT_TRUE(watch.changed(cloth, 0.2)) << "back from change " << i;
  }
}

TEST(ClothWatch, DoesNotMindWhatMovesNoPoint) {
  Cloth cloth = make_grid(square_spec(4));
  ClothWatch watch;
  watch.changed(cloth, 0.1);
  cloth.strain_limit = 0.3;
  cloth.friction = 2;
  cloth.rest_positions.setZero();
  EXPECT_FALSE(watch.changed(cloth, 0.1));
}

}  // namespace
}  // namespace clothsim::cloth_watch_test
