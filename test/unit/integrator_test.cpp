#include "clothsim/dynamics/integrator.h"

#include <set>

#include "verification/testing.h"

namespace clothsim {
namespace {

using namespace testing;

TEST(Integrator, NamesAreThoseOfTheMethods) {
  const std::vector<std::string> names = method_names();
  EXPECT_EQ(names.size(), std::variant_size_v<Integrator>);
  EXPECT_EQ(std::set<std::string>(names.begin(), names.end()).size(), names.size());
  EXPECT_EQ(names.front(), "verlet");
  for (std::size_t i = 0; i < names.size(); ++i) {
    const Integrator method = make_integrator(names[i]);
    EXPECT_EQ(method.index(), i);
    EXPECT_EQ(std::visit([](const auto& m) { return std::string(m.name); }, method), names[i]);
  }
}

template <typename Method>
class EachIntegrator : public ::testing::Test {};
TYPED_TEST_SUITE(EachIntegrator, EachMethod);

TYPED_TEST(EachIntegrator, PinsMoveAtTheirOwnVelocity) {
  // Whatever pulls at them, and without drag.
  ClothSpec spec = square_spec(4);
  spec.material.damping = 5;
  spec.pinned = {{0, 0, ""}, {3, 0, ""}};
  const Cloth cloth = make_grid(spec);
  State state{cloth.rest_positions, Points::Zero(16, 3), 0.5};
  const Eigen::RowVector3d v(0.1, -0.2, 0.3);
  state.velocities.row(0) = v;
  TypeParam method;
  run(method, cloth, Loads{}, 1e-3, 100, state);
  EXPECT_LT((state.positions.row(0) - cloth.rest_positions.row(0) - 0.1 * v).norm(), 1e-13);
  EXPECT_EQ(state.velocities.row(0), v);
  EXPECT_EQ(state.positions.row(3), cloth.rest_positions.row(3));
  EXPECT_EQ(state.time, 0.5) << "time is the caller's";
  EXPECT_GT((state.positions.row(15) - cloth.rest_positions.row(15)).norm(), 1e-3);
}

TYPED_TEST(EachIntegrator, TakesClothsOfOtherSizesInTurn) {
  TypeParam method;
  for (const int side : {6, 3, 8}) {
    const ClothSpec spec = square_spec(side);
    const Cloth cloth = make_grid(spec);
    State state{shaken(cloth, 0.01, 1), Points::Zero(side * side, 3), 0};
    State fresh_state = state;
    TypeParam fresh;
    method = TypeParam();
    run(method, cloth, Loads{}, 1e-4, 10, state);
    run(fresh, cloth, Loads{}, 1e-4, 10, fresh_state);
    EXPECT_EQ(state.positions, fresh_state.positions);
  }
}

}  // namespace
}  // namespace clothsim
