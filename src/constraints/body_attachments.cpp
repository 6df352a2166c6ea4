#include "clothsim/constraints/body_attachments.h"

#include <algorithm>
#include <cmath>

#include "clothsim/constraints/local_cloth.h"
#include "clothsim/dynamics/drag.h"

namespace clothsim {
namespace {

using Matrix6 = Eigen::Matrix<double, 6, 6>;
using Vector6 = Eigen::Matrix<double, 6, 1>;

/// Velocity at a place by the velocity and the angular velocity of a motion.
Eigen::Matrix<double, 3, 6> jacobian(const Vector3& arm) {
  Eigen::Matrix<double, 3, 6> result;
  result << Matrix3::Identity(), -cross_matrix(arm);
  return result;
}

}  // namespace

void BodyAttachments::attach(const std::vector<Attachment>& attachments) {
  const std::vector<Row> last = std::move(rows_);
  rows_.clear();
  for (const Attachment& a : attachments) {
    const auto known = std::find_if(last.begin(), last.end(), [&](const Row& r) {
      return r.attachment.point == a.point && r.attachment.body == a.body;
    });
    rows_.push_back(known != last.end() ? *known : Row());
    rows_.back().attachment = a;
  }
  blocks_.clear();
  for (std::size_t i = 0; i < rows_.size(); ++i) {
    const bool is_new = i == 0 || rows_[i].attachment.body != rows_[i - 1].attachment.body;
    if (is_new) blocks_.push_back({i, i, Matrix6::Zero()});
    blocks_.back().end = i + 1;
  }
}

bool BodyAttachments::holds(int point) const {
  return std::any_of(rows_.begin(), rows_.end(),
                     [&](const Row& r) { return r.attachment.point == point; });
}

void BodyAttachments::begin_frame() {
  for (Row& r : rows_) {
    r.frame_impulse.setZero();
    r.work = 0;
  }
}

std::vector<BodyTouch> BodyAttachments::touches(const Cloth& cloth,
                                                const std::vector<MovingCollider>& colliders,
                                                const Points& start, double reach) const {
  std::vector<BodyTouch> result;
  for (std::size_t k = 0; k < colliders.size() && !rows_.empty(); ++k) {
    if (!colliders[k].enabled()) continue;
    const double keeps = clearance(colliders[k].shape(), cloth).points;
    for (const Row& r : rows_) {
      const Vector3 x = to_world(colliders[r.attachment.body].pose(), r.attachment.place);
      if (!colliders[k].reaches({x, x}, reach + keeps)) continue;
      const Vector3 side = to_local(colliders[k].previous(), row(start, r.attachment.point));
      const Distance distance =
          signed_distance(colliders[k].shape(), to_local(colliders[k].pose(), x), side);
      const double gap = distance.value - keeps + cloth.nearer_by(r.attachment.point);
      if (gap > reach) continue;
      result.push_back({r.attachment.body, k, x, colliders[k].pose().orientation * distance.normal,
                        gap, colliders[k].friction()});
    }
  }
  return result;
}

void BodyAttachments::prepare(const Cloth& cloth, const ContactStep& step,
                              const std::vector<MovingCollider>& colliders, State& state) {
  RigidBodies& bodies = *step.bodies;
  const double scale = h_ > 0 ? step.h / h_ : 0;
  h_ = step.h;
  for (Row& r : rows_) {
    const int i = r.attachment.point;
    r.x = to_world(colliders[r.attachment.body].pose(), r.attachment.place);
    r.inv_mass = 1 / cloth.mass[i];
    RigidMotion& body = bodies.motion(r.attachment.body);
    r.impulse *= scale;
    state.velocities.row(i) += r.inv_mass * r.impulse.transpose();
    body.give(-r.impulse, r.x);
  }
  for (Block& block : blocks_) {
    set_gain(block, bodies.motion(rows_[block.first].attachment.body));
  }
}

/// With the inverse masses W of the body, the velocities J_i u of its places in a motion u, and
/// S = sum of m_i J_i^T J_i, the change (1 + W S)^-1 W b of its motion takes up the momentum
/// b = sum of m_i J_i^T (v_i - J_i u) of the points.
void BodyAttachments::set_gain(Block& block, const RigidMotion& body) const {
  Matrix6 of_points = Matrix6::Zero(), of_body = Matrix6::Zero();
  of_body.topLeftCorner<3, 3>() = body.inv_mass;
  of_body.bottomRightCorner<3, 3>() = body.inv_inertia;
  for (std::size_t i = block.first; i < block.end; ++i) {
    const Eigen::Matrix<double, 3, 6> j = jacobian(rows_[i].x - body.center);
    of_points += j.transpose() * j / rows_[i].inv_mass;
  }
  block.gain = (Matrix6::Identity() + of_body * of_points).partialPivLu().solve(of_body);
}

double BodyAttachments::solve_pass(RigidBodies& bodies, Points& velocities) {
  double largest = 0;
  for (const Block& block : blocks_) {
    RigidMotion& body = bodies.motion(rows_[block.first].attachment.body);
    Wrench lacking;  // momentum about the body's centre
    for (std::size_t i = block.first; i < block.end; ++i) {
      const Row& r = rows_[i];
      const Vector3 v = row(velocities, r.attachment.point) - body.velocity_at(r.x);
      lacking.add(r.x - body.center, v / r.inv_mass);
    }
    Vector6 momentum;
    momentum << lacking.force, lacking.torque;
    const Vector6 change = block.gain * momentum;
    body.velocity += change.head<3>();
    body.angular_velocity += change.tail<3>();
    for (std::size_t i = block.first; i < block.end; ++i) {
      Row& r = rows_[i];
      const Vector3 wanted = body.velocity_at(r.x);
      const Vector3 more = wanted - row(velocities, r.attachment.point);
      r.impulse += more / r.inv_mass;
      velocities.row(r.attachment.point) = wanted.transpose();
      largest = std::max(largest, more.norm());
    }
  }
  return largest;
}

void BodyAttachments::end_step(const Cloth& cloth, double h, const Points& velocities) {
  for (Row& r : rows_) {
    const double scale = impulse_as_force(cloth, r.attachment.point, h);
    r.frame_impulse -= scale * r.impulse;
    r.work += std::abs(scale * r.impulse.dot(row(velocities, r.attachment.point)));
  }
}

void BodyAttachments::project(const std::vector<MovingCollider>& colliders,
                              Points& positions) const {
  for (const Row& r : rows_) {
    const Attachment& a = r.attachment;
    positions.row(a.point) = to_world(colliders[a.body].pose(), a.place).transpose();
  }
}

void BodyAttachments::fix(bool fixed, Cloth& cloth) const {
  for (const Row& r : rows_) cloth.inv_mass[r.attachment.point] = fixed ? 0 : r.inv_mass;
}

double BodyAttachments::distance(std::size_t number, const std::vector<MovingCollider>& colliders,
                                 const Points& positions) const {
  const Attachment& a = rows_[number].attachment;
  return (to_world(colliders[a.body].pose(), a.place) - row(positions, a.point)).norm();
}

double BodyAttachments::work() const {
  double sum = 0;
  for (const Row& r : rows_) sum += r.work;
  return sum;
}

void BodyAttachments::reset() {
  for (Row& r : rows_) r.impulse.setZero();
  h_ = 0;
}

void BodyAttachments::write(MemoryWriter& memory) const {
  memory.add(h_);
  for (const Row& r : rows_) memory.add(r.impulse);
}

void BodyAttachments::read(MemoryReader& memory) {
  h_ = std::max(0.0, memory.number());
  for (Row& r : rows_) r.impulse = memory.vector();
}

}  // namespace clothsim
