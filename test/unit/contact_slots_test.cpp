#include "clothsim/constraints/contact_slots.h"

#include "verification/testing.h"

namespace clothsim::contact_slots_test {
namespace {

using namespace test;

constexpr double h = 1e-3;                   // [s]
constexpr double displacement_factor = 0.5;  // of a step
constexpr double friction = 0.4;             // of all contacts
constexpr double offset = surface_offset;

const Shape shapes[] = {Sphere{0.3}, Plane{}, Plane{true}, Capsule{0.8, 0.1},
                        Cuboid{{0.8, 0.3, 0.4}}};

/// A cloth of loose points about the shape, some of them pinned.
Cloth loose(int count) {
  ClothSpec spec = chain_spec(count, 1, 0);
  spec.pinned = {{0, 3, ""}, {0, 17, ""}};
  return make_grid(spec);
}

/// A collider that moves and turns.
MovingCollider moving(const Shape& shape) {
  ColliderSpec spec;
  spec.shape = shape;
  spec.friction = friction;
  spec.pose = {{0.1, 0.05, -0.1}, Eigen::Quaterniond(Eigen::AngleAxisd(0.5, Vector3::UnitX()))};
  MovingCollider collider(spec);
  collider.set_target(
      {{0.1, 0.06, -0.09}, Eigen::Quaterniond(Eigen::AngleAxisd(0.51, Vector3::UnitX()))}, 10 * h);
  collider.advance(h);
  return collider;
}

/// ContactSlots one point at a time, by signed_distance() and ContactImpulse.
struct Twin {
  void find(const MovingCollider& c, const Cloth& cloth, const ContactStep& step,
            const State& state) {
    held.resize(static_cast<std::size_t>(cloth.num_points()));
    for (int i = 0; i < cloth.num_points(); ++i) {
      std::optional<ContactImpulse> last = held[static_cast<std::size_t>(i)];
      const bool was_held = last && last->normal_impulse > 0;
      held[static_cast<std::size_t>(i)].reset();
      if (cloth.inv_mass[i] == 0) continue;

      const Vector3 x = row(state.positions, i), u = c.velocity_at(x);
      const Vector3 back = step.displacement_factor * h * (row(step.drifted, i) - u);
      const Vector3 from = to_local(c.previous(), row(step.start, i));
      const Distance d =
          signed_distance(c.shape(), to_local(c.pose(), was_held ? x - back : x), from);
      ContactImpulse contact;
      contact.normal = c.pose().orientation * d.normal;
      contact.surface_velocity = u;
      contact.friction = c.friction();
      const double gap = d.value - offset - (was_held ? 0 : contact.normal.dot(back));
      contact.target_velocity = -std::max(gap, 0.0) / h;
      const double rate = contact.normal.dot(row(state.velocities, i) - u);
      if (!was_held && rate >= contact.target_velocity && gap > 0) continue;
      if (was_held) contact.keep(*last);
      held[static_cast<std::size_t>(i)] = contact;
    }
  }

  void warm_start(double scale, Points& velocities) {
    for_each([&](int i, ContactImpulse& c) {
      c.warm_start(scale);
      velocities.row(i) += c.total().transpose();
    });
  }

  void solve_pass(Points& velocities) {
    for_each([&](int i, ContactImpulse& c) {
      velocities.row(i) += c.update(row(velocities, i), 1).transpose();
    });
  }

  static void project_positions(const MovingCollider& c, const Cloth& cloth, const Points& start,
                                Points& positions) {
    for (int i = 0; i < cloth.num_points(); ++i) {
      if (cloth.inv_mass[i] == 0) continue;
      const Distance d = signed_distance(c.shape(), to_local(c.pose(), row(positions, i)),
                                         to_local(c.previous(), row(start, i)));
      positions.row(i) +=
          std::max(0.0, offset - d.value) * (c.pose().orientation * d.normal).transpose();
    }
  }

  template <typename Visit>
  void for_each(const Visit& visit) {
    for (int i = 0; i < static_cast<int>(held.size()); ++i) {
      if (held[static_cast<std::size_t>(i)]) visit(i, *held[static_cast<std::size_t>(i)]);
    }
  }

  std::vector<std::optional<ContactImpulse>> held;
};

/// The distance of a block's nearest point from a collider [m].
double least_distance(const MovingCollider& collider, int b, const Cloth& cloth,
                      const Points& start, const Points& positions) {
  double least = std::numeric_limits<double>::infinity();
  for (int i = ContactSlots::first_of(b); i < ContactSlots::end_of(b, cloth); ++i) {
    const Vector3 x = to_local(collider.pose(), row(positions, i));
    const Vector3 before = to_local(collider.previous(), row(start, i));
    least = std::min(least, signed_distance(collider.shape(), x, before).value);
  }
  return least;
}

TEST(ContactSlots, EveryPointHasTheContactThatOneAloneWouldHave) {
  constexpr int count = 8 * 24 + 5;
  const Span spans[] = {{0, 16}, {16, 17}, {17, 25}};
  const Cloth cloth = loose(count);
  for (const Shape& shape : shapes) {
    MovingCollider collider = moving(shape);
    State state{random_points(count, 0.35, 1), random_points(count, 3, 2), 0};
    State other = state;
    ContactSlots slots;
    slots.reset(cloth);
    Twin twin;
    int touched = 0, slid = 0;
    for (int k = 0; k < 30; ++k) {
      collider.advance(h);
      const Points start = state.positions, other_start = other.positions;
      for (State* s : {&state, &other}) s->positions += h * s->velocities;
      const Points drifted = state.velocities, other_drifted = other.velocities;
      const ContactStep step{h, displacement_factor, start, drifted, Workers()};
      const ContactStep other_step{h, displacement_factor, other_start, other_drifted, Workers()};
      const double scale = k % 2 == 0 ? 1.0 : 0.7;

      const ContactSlots::Detector detector(collider, cloth, offset, {});
      slots.start_over();
      for (const Span& span : spans) {
        double nearest[Span::longest];
        slots.find(span, detector, cloth, step, state, nearest);
        for (int b = span.begin; b < span.end; ++b) {
          const double least = nearest[b - span.begin];
          if (!std::isfinite(least)) continue;  // a block with impulses
          EXPECT_NEAR(least, least_distance(collider, b, cloth, start, state.positions), 1e-12);
        }
      }
      slots.close();
      slots.warm_start(cloth, scale, state.velocities);
      for (int pass = 0; pass < 3; ++pass) slots.solve_pass(friction, state.velocities);
      for (const Span& span : spans) {
        double least[Span::longest];
        ContactSlots::project_positions(span, detector,
                                        &cloth.inv_mass[ContactSlots::first_of(span.begin)], start,
                                        state.positions, least);
      }

      twin.find(collider, cloth, other_step, other);
      twin.warm_start(scale, other.velocities);
      for (int pass = 0; pass < 3; ++pass) twin.solve_pass(other.velocities);
      Twin::project_positions(collider, cloth, other_start, other.positions);

      ASSERT_LT((state.velocities - other.velocities).cwiseAbs().maxCoeff(), 1e-11) << k;
      ASSERT_LT((state.positions - other.positions).cwiseAbs().maxCoeff(), 1e-13) << k;
      int held = 0;
      twin.for_each([&](int i, const ContactImpulse& c) {
        held += c.normal_impulse > 0;
        slid +=
            c.normal_impulse > 0 && c.friction_impulse.norm() > 0.999 * friction * c.normal_impulse;
        EXPECT_EQ(slots.touches(i), true);
      });
      EXPECT_EQ(slots.count(), held);
      touched += held;
      // Pressed on again.
      for (State* s : {&state, &other}) {
        s->velocities += random_points(count, 1, 10 + k) - 10 * s->positions;
      }
    }
    EXPECT_GT(touched, 40);
    EXPECT_GT(slid, 10);
  }
}

TEST(ContactSlots, ASweepTellsTheLargestChange) {
  const Cloth cloth = loose(21);
  ContactSlots slots;
  slots.reset(cloth);
  const Vector3 up(0, 0, 1), still(0, 0, 0);
  Points velocities = Points::Zero(21, 3);
  velocities(5, 2) = -3;
  velocities(20, 2) = -4;
  for (const int point : {5, 20}) slots.put(point, up, still, 0);
  slots.close();
  EXPECT_EQ(slots.solve_pass(0, velocities), 16);
  EXPECT_EQ(slots.solve_pass(0, velocities), 0);
  EXPECT_EQ(velocities, Points::Zero(21, 3));
  EXPECT_EQ(slots.count(), 2);
}

TEST(ContactSlots, ImpulsesOfContactsThatEndAreDropped) {
  const Cloth cloth = loose(40);
  ContactSlots slots;
  slots.reset(cloth);
  ContactImpulse impulse;
  impulse.normal_impulse = 2;
  for (const int point : {3, 5, 30}) slots.set_impulse(point, impulse);  // 3 is pinned
  EXPECT_EQ(slots.count(), 3);
  const MovingCollider plane(
      {"", Plane{}, {Vector3::Zero(), Eigen::Quaterniond::Identity()}, 0, ""});
  const Points at = Points::Constant(40, 3, offset), still = Points::Zero(40, 3);
  State state{at, still, 0};
  slots.start_over();
  double nearest[1];
  slots.find({3, 4}, ContactSlots::Detector(plane, cloth, offset, {}), cloth,
             {h, displacement_factor, at, still, Workers()}, state, nearest);
  EXPECT_TRUE(std::isinf(nearest[0])) << "a point with an impulse does not sleep";
  slots.close();
  slots.warm_start(cloth, 0.5, state.velocities);
  EXPECT_EQ(slots.count(), 1) << "the other two are in a block that nobody looked at";
  EXPECT_EQ(state.velocities.cwiseAbs().sum(), 1);
  EXPECT_EQ(state.velocities(30, 2), 1);
}

}  // namespace
}  // namespace clothsim::contact_slots_test
