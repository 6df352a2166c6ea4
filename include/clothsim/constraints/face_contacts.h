#pragma once

#include <cstdint>
#include <vector>

#include "clothsim/constraints/contact_list.h"
#include "clothsim/constraints/corners.h"
#include "clothsim/constraints/face_approach.h"
#include "clothsim/constraints/local_cloth.h"
#include "clothsim/constraints/pinches.h"
#include "clothsim/constraints/rigid_bodies.h"
#include "clothsim/constraints/triangle_blocks.h"
#include "clothsim/model/memory.h"
#include "clothsim/model/state.h"
#include "clothsim/model/wrench.h"
#include "clothsim/shapes/face_distance.h"

namespace clothsim {

/// A triangle that was in a collider when a step began.
struct PenetratingFace {
  int triangle;
  std::size_t contact;    // in FaceContacts
  double depth;           // [m] at the step's start
  CornerWeights weights;  // of the point where it touches
};

/// Contacts of edges and faces of a cloth with colliders that are not smooth relative to its
/// triangles. As in ColliderContacts, except that each contact acts on the three corners of a
/// triangle, by their barycentric weights and inverse masses. Contact at a corner is left to the
/// contact of that point. Triangles with a corner that is held in the solid have none, as nothing
/// could bring them out. Beside other held corners a triangle may sink in, see raised_at_held() and
/// leeway().
class FaceContacts {
 public:
  /// Begins a step of h [s]: the present contacts become those of the last step.
  void start_over(double h);

  /// A collider beside a cloth, in a step.
  struct ColliderQuery {
    int number;  // of the collider
    const MovingCollider& collider;
    const Cloth& cloth;
    const ContactStep& step;
    double speed;      // of the points, at most [m/s]
    double margin;     // distance from where impulses act within which a triangle may touch [m]
    double reach;      // the same until the next detection [m]
    double travelled;  // bound on the displacements of points and surface until now [m]
    double in_step;    // the same in this step [m]
    LocalCloth& local;
    State& state;
    std::vector<PenetratingFace>& penetrating_faces;
  };

  /// Adds the contacts of the next collider. Triangles that the step took through the shape are
  /// moved back.
  void find(const ColliderQuery&);

  /// The same for the triangles that were within reach in the last find().
  void find_again(const ColliderQuery&);

  /// Corners of these triangles, ascending.
  const std::vector<int>& near_points(std::size_t collider) const { return at_[collider].points; }

  /// Gives the contacts the impulses of the last step. `bodies`: none or those of the scene.
  void warm_start(const Points& positions, RigidBodies*, Points& velocities);

  /// Calls visit(triangle, weights of its corners, normal, distance [m]) for each contact with a
  /// collider.
  template <typename Visit>
  void for_each_on(int collider, Visit&& visit) const {
    for (std::size_t k = 0; k < places_.size(); ++k) {
      const Contact& c = list_.contacts()[k];
      if (collider_of(c) != collider) continue;
      const CornerWeights weights{c.weights[0], c.weights[1], c.weights[2]};
      visit(triangle_of(c), weights, c.impulse.normal, places_[k].distance);
    }
  }

  /// Adds the changes of velocities by the impulses [m/s].
  void add_velocities(Points& sum) const { list_.add_velocities(sum); }

  /// Makes the corners immovable that two colliders hold. A triangle with such corners may be
  /// nearer to the collider than the offset, by the weighted share of the distance that they lack,
  /// as layers that have to be thinner are.
  void release_pinched(const Pinches&, const std::vector<MovingCollider>&, const Cloth&,
                       const ContactStep&);

  /// One pass over all contacts. Returns the largest change of a velocity [m/s]. `bodies`: none or
  /// those of the scene, whose velocities change, too.
  double solve_pass(RigidBodies*, Points& velocities);

  /// Moves the corners of triangles that are in the collider out, in local.to, and marks them as
  /// `moved`. Triangles with a point that is `held` (empty: none) are left alone.
  void project_positions(int number, const MovingCollider&, const Cloth&, double h,
                         const std::vector<char>& held, LocalCloth&, std::vector<char>& moved);

  /// Turns a contact to another direction out of the solid, at that speed [m/s].
  void redirect(std::size_t contact, const Vector3& normal, double speed) {
    list_.contacts()[contact].impulse.normal = normal;
    list_.contacts()[contact].impulse.target_velocity = places_[contact].lever * speed;
  }

  /// As ContactSlots::add_impulses(), to the sum of each collider, about the origin of its frame.
  void add_impulses(const std::vector<MovingCollider>&, const Scalars& masses,
                    const Points& positions, std::vector<Wrench>& sums) const;

  std::size_t size() const { return places_.size(); }  // of this step
  const Contact& contact(std::size_t i) const { return list_.contacts()[i]; }
  int collider(std::size_t i) const { return collider_of(contact(i)); }
  const Vector3& place(std::size_t i) const { return places_[i].x; }  // in the world [m]
  /// Keeps a contact from pushing its triangle away from the surface.
  void forbid_recovery(std::size_t i) {
    double& target = list_.contacts()[i].impulse.target_velocity;
    target = std::min(target, 0.0);
  }
  /// Takes another impulse of a contact.
  void keep(std::size_t i, const ContactImpulse& impulse) {
    list_.contacts()[i].impulse.keep(impulse);
  }
  int count() const { return list_.count(); }  // that carry an impulse
  void reset();
  void write(MemoryWriter& memory) const { list_.write(memory); }
  void read(MemoryReader& memory) { list_.read(memory); }

 private:
  /// Further data of a contact.
  struct Place {
    double lever;     // velocity there over that of the fastest corner
    double distance;  // from the surface, where impulses act [m]
    Vector3 x;        // in the world [m]
  };

  /// Features of a triangle in contact: its edges, from corner i to i + 1, and its face.
  enum Feature : std::size_t { first_edge, second_edge, third_edge, face, features };
  using FeatureDistances = std::array<std::optional<FaceDistance>, features>;

  /// A triangle within reach.
  struct NearTriangle {
    int triangle = 0;
    double distance = 0;                   // a lower bound, exact where it is beside [m]
    double reached_at = 0;                 // displacements at which it may reach the surface [m]
    bool is_beside = false;                // it touches from outside, neither led out nor stopped
    Triangle corners{};                    // where impulses act, in the collider's frame [m]
    std::optional<CornerWeights> nearest;  // of its place nearest to the surface; empty: unknown
    FeatureDistances touching;             // features that may touch
  };

  /// A key has a collider, a triangle and the feature in contact: an edge, 0 to 2, or the face, 3.
  enum { triangle_bit = 2, collider_bit = 32 };
  static std::uint64_t key_of(int collider, int triangle, std::size_t feature) {
    return static_cast<std::uint64_t>(collider) << collider_bit |
           static_cast<std::uint64_t>(triangle) << triangle_bit | feature;
  }
  static int collider_of(const Contact& c) { return static_cast<int>(c.key >> collider_bit); }
  static int triangle_of(const Contact& c) {
    return static_cast<int>((c.key & 0xffffffff) >> triangle_bit);
  }

  /// The margin of a query for a triangle with its own speed.
  static double margin_of(const ColliderQuery&, const Corners&);

  /// A triangle of points in the collider's frame, see raised_at_held().
  static Triangle raised_triangle(const ColliderQuery&, const Points&, const Corners&);

  /// Distance of a triangle where impulses act, with leeway(); empty beyond the reach.
  static std::optional<FaceDistance> measure(const ColliderQuery&, NearTriangle&,
                                             MeasuredTriangle&);

  /// Measures a triangle and adds its contacts within `margin` [m]. To be called in the order of
  /// their keys.
  void look_at(const ColliderQuery&, double margin, NearTriangle&, MeasuredTriangle&,
               ContactList::Last&);

  /// The same without measuring, where the triangle has hardly moved since: as if its features
  /// touched planes. False where it has moved too far.
  bool follow(const ColliderQuery&, const NearTriangle&, ContactList::Last&);

  /// Feature in contact; empty where a corner alone touches.
  static std::optional<Feature> feature_of(const CornerWeights&);

  static bool passes_by(const ColliderQuery&, const Corners&);

  /// Adds a contact at `distance`, if it matters in this step. `last`: the contact in the last
  /// step; null: none.
  void add(const ColliderQuery&, std::uint64_t key, const Contact* last,
           const FaceDistance& distance, bool swept, double depth);

  /// The triangles of a cloth at a collider.
  struct AtCollider {
    std::vector<NearTriangle> near;          // ascending
    std::vector<int> points;                 // their corners, ascending
    std::vector<MeasuredTriangle> measured;  // by triangle
  };
  AtCollider& at_collider(int number, const Cloth&);

  /// A lower bound on the distance from the collider, from the last measurement [m].
  static double distance_of(const ColliderQuery&, const MeasuredTriangle&, const Corners&);

  TriangleBlocks blocks_;
  std::vector<AtCollider> at_;  // by collider
  ContactList list_;
  std::vector<Place> places_;  // as list_; empty for a list that was read
};

}  // namespace clothsim
