#include "clothsim/dynamics/integrator.h"

#include <set>

#include "verification/testing.h"

namespace clothsim::integrator_test {
namespace {

using namespace test;

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

TEST(MethodParameters, AreThoseOfTheirMethod) {
  EXPECT_EQ(default_parameters("auto").index(), 0u);
  EXPECT_EQ(default_parameters("magic").index(), 0u);
  const std::vector<std::string> names = method_names();
  for (std::size_t i = 0; i < names.size(); ++i) {
    const MethodParameters parameters = default_parameters(names[i]);
    EXPECT_EQ(parameters.index(), i + 1);
    EXPECT_NO_THROW(validate(parameters, names[i]));
    EXPECT_NO_THROW(validate({}, names[i]));
    EXPECT_TRUE(same(parameters, default_parameters(names[i])));
    EXPECT_FALSE(same(parameters, {}));
    for (const std::string& other : names) {
      if (other != names[i]) {
        EXPECT_THROW(validate(parameters, other), InvalidValue) << other;
      }
    }
  }
}

template <typename Method>
class EachIntegrator : public ::testing::Test {};
TYPED_TEST_SUITE(EachIntegrator, EachMethod);

TYPED_TEST(EachIntegrator, PinsMoveAtTheirOwnVelocity) {
  // Under any pull, and without drag.
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

TYPED_TEST(EachIntegrator, ParametersAreCheckedComparedAndUsed) {
  using Parameters = typename TypeParam::Parameters;
  std::set<std::string> keys;
  const auto check = [&](const char* key, const auto& initial, const Range& range) {
    EXPECT_TRUE(keys.insert(key).second) << key;
    EXPECT_GE(initial, range.min);
    EXPECT_LE(initial, range.max);

    // The same parameters with one other value.
    const auto with = [&](double value) {
      Parameters changed;
      const auto set = [&](const char* name, auto& target, const Range&) {
        if (std::string(name) == key) target = static_cast<std::decay_t<decltype(target)>>(value);
      };
      Parameters::each(changed, set);
      return MethodParameters(changed);
    };
    EXPECT_NO_THROW(validate(with(range.min), TypeParam::name));
    EXPECT_NO_THROW(validate(with(range.max), TypeParam::name));
    EXPECT_FALSE(same(with(range.max), Parameters())) << key;
    for (const double wrong : {range.min - 1, 2 * range.max + 1}) {
      try {
        validate(with(wrong), TypeParam::name);
        ADD_FAILURE() << key << ' ' << wrong;
      } catch (const InvalidValue& error) {
        EXPECT_EQ(error.key(), std::vector<std::string>{key});
      }
    }

    // Each parameter has an effect: its least and largest values give other bits.
    const auto end = [&](double value) {
      const Cloth cloth = make_grid(square_spec(6));
      State state{shaken(cloth, 0.1, 1), Points::Zero(36, 3), 0};
      Integrator method = make_integrator(TypeParam::name, with(value));
      std::visit([&](auto& m) { run(m, cloth, Loads{}, 0.02, 3, state); }, method);
      return state.positions;
    };
    EXPECT_NE(end(range.min), end(std::min(range.max, 1000.0))) << key;
  };
  const Parameters initial;
  Parameters::each(initial, check);
}

TYPED_TEST(EachIntegrator, TakesClothsOfOtherSizesInTurn) {
  TypeParam method;
  for (const int side : {6, 3, 8}) {
    const ClothSpec spec = square_spec(side);
    const Cloth cloth = make_grid(spec);
    State state{shaken(cloth, 0.01, 1), Points::Zero(side * side, 3), 0};
    State fresh_state = state;
    TypeParam fresh;
    run(method, cloth, Loads{}, 1e-4, 10, state);
    run(fresh, cloth, Loads{}, 1e-4, 10, fresh_state);
    EXPECT_EQ(state.positions, fresh_state.positions);
  }
}

}  // namespace
}  // namespace clothsim::integrator_test
