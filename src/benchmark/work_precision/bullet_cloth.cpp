#include "bullet_cloth.h"

#include <BulletSoftBody/btDeformableBodySolver.h>
#include <BulletSoftBody/btDeformableGravityForce.h>
#include <BulletSoftBody/btDeformableMassSpringForce.h>
#include <BulletSoftBody/btDeformableMultiBodyConstraintSolver.h>
#include <BulletSoftBody/btDeformableMultiBodyDynamicsWorld.h>
#include <BulletSoftBody/btSoftBody.h>
#include <BulletSoftBody/btSoftBodyRigidBodyCollisionConfiguration.h>
#include <BulletSoftBody/btSoftRigidDynamicsWorld.h>
#include <btBulletDynamicsCommon.h>

#include <cmath>

#include "clothsim/dynamics/springs.h"
#include "clothsim/model/errors.h"
#include "clothsim/model/grid.h"

namespace clothsim::work_precision {
namespace {

btVector3 to_bullet(const Vector3& v) {
  return {static_cast<btScalar>(v.x()), static_cast<btScalar>(v.y()), static_cast<btScalar>(v.z())};
}

/// Parts of both kinds of world; constructed before them and destroyed after.
struct Parts {
  btSoftBodyRigidBodyCollisionConfiguration configuration;
  btCollisionDispatcher dispatcher{&configuration};
  btDbvtBroadphase broadphase;
};

class BulletCloth : public Stepper {
 public:
  BulletCloth(const Scene& scene, int substeps)
      : cloth_(make_grid(scene.cloth)),
        state_(start_state(scene.cloth, cloth_, scene.simulation.seed)),
        frame_(1 / scene.simulation.frames_per_second),
        substeps_(substeps) {}

  StepReport step() override {
    const double h = frame_ / substeps_;
    for (int k = 0; k < substeps_; ++k) substep(static_cast<btScalar>(h));
    for (int i = 0; i < cloth_.num_points(); ++i) {
      const btSoftBody::Node& node = body_->m_nodes[i];
      state_.positions.row(i) << node.m_x.x(), node.m_x.y(), node.m_x.z();
      state_.velocities.row(i) << node.m_v.x(), node.m_v.y(), node.m_v.z();
    }
    state_.time += frame_;
    if (!state_.positions.allFinite() || !state_.velocities.allFinite()) {
      throw Diverged("Bullet's cloth left the finite numbers");
    }
    StepReport report;
    report.method = name();
    report.substeps = substeps_;
    return report;
  }

  const State& state() const override { return state_; }

 protected:
  virtual void substep(btScalar h) = 0;
  virtual const char* name() const = 0;

  /// Points with their masses, and a link for each spring, appended by `append(a, b, stiffness)`.
  template <typename Append>
  void build(btSoftBodyWorldInfo& info, Append&& append) {
    std::vector<btVector3> x;
    std::vector<btScalar> m;
    for (int i = 0; i < cloth_.num_points(); ++i) {
      x.push_back(to_bullet(state_.positions.row(i).transpose()));
      m.push_back(cloth_.inv_mass[i] > 0 ? static_cast<btScalar>(cloth_.mass[i]) : 0);
    }
    body_ = new btSoftBody(&info, cloth_.num_points(), x.data(), m.data());  // owned by the world
    body_->m_cfg.collisions = 0;
    body_->setCollisionFlags(btCollisionObject::CF_NO_CONTACT_RESPONSE);
    body_->setActivationState(DISABLE_DEACTIVATION);
    for_each_spring(cloth_, [&](const SpringRun& run, int a, int b) { append(run, a, b); });
  }

  Cloth cloth_;
  State state_;
  double frame_;  // [s]
  int substeps_;
  btSoftBody* body_ = nullptr;
};

class PositionCloth : public BulletCloth {
 public:
  PositionCloth(const Scene& scene, int substeps, int iterations, bool matched)
      : BulletCloth(scene, substeps) {
    const double h = frame_ / substeps;
    world_.setGravity(to_bullet(scene.simulation.gravity));
    btSoftBodyWorldInfo& info = world_.getWorldInfo();
    info.m_gravity = to_bullet(scene.simulation.gravity);
    info.m_dispatcher = &parts_.dispatcher;
    info.m_broadphase = &parts_.broadphase;
    info.air_density = 0;
    info.m_sparsesdf.Initialize();
    build(info, [&](const SpringRun& run, int a, int b) {
      btSoftBody::Material* material = body_->m_materials[0];
      if (matched) {
        // A compliant projection of one step, and the same by a sequence of weaker ones.
        const double w = cloth_.inv_mass[a] + cloth_.inv_mass[b];
        const double share = w / (w + 1 / (run.stiffness * h * h));
        material = body_->appendMaterial();
        material->m_kLST = static_cast<btScalar>(1 - std::pow(1 - share, 1.0 / iterations));
      }
      body_->appendLink(a, b, material);
    });
    body_->m_cfg.piterations = iterations;
    body_->m_cfg.kDP = static_cast<btScalar>(1 - std::exp(-cloth_.damping * h));
    world_.addSoftBody(body_);
  }

  ~PositionCloth() override {
    world_.removeSoftBody(body_);
    delete body_;
  }

 private:
  void substep(btScalar h) override { world_.stepSimulation(h, 0); }
  const char* name() const override { return "bullet"; }

  Parts parts_;
  btSequentialImpulseConstraintSolver solver_;
  btSoftRigidDynamicsWorld world_{&parts_.dispatcher, &parts_.broadphase, &solver_,
                                  &parts_.configuration};
};

class SpringCloth : public BulletCloth {
 public:
  SpringCloth(const Scene& scene, int substeps) : BulletCloth(scene, substeps) {
    const btVector3 gravity = to_bullet(scene.simulation.gravity);
    const double h = frame_ / substeps;
    solver_.setDeformableSolver(&body_solver_);
    world_.setGravity(gravity);
    world_.getWorldInfo().m_gravity = gravity;
    world_.getWorldInfo().m_sparsesdf.Initialize();
    build(world_.getWorldInfo(), [&](const SpringRun& run, int a, int b) {
      body_->appendLink(a, b);
      if (run.family == SpringFamily::bending) {
        body_->m_links[body_->m_links.size() - 1].m_bbending = -1;  // one signed bit
      }
    });
    body_->m_cfg.drag = static_cast<btScalar>(1 - std::exp(-cloth_.damping * h));
    body_->m_sleepingThreshold = 0;
    world_.addSoftBody(body_);
    const double ks = scene.cloth.material.ks;
    springs_ = std::make_unique<btDeformableMassSpringForce>(static_cast<btScalar>(ks), btScalar(0),
                                                             true, 0.2 * ks);
    gravity_ = std::make_unique<btDeformableGravityForce>(gravity);
    world_.addForce(body_, springs_.get());
    world_.addForce(body_, gravity_.get());
  }

  ~SpringCloth() override {
    world_.removeSoftBody(body_);
    delete body_;
  }

 private:
  void substep(btScalar h) override { world_.stepSimulation(h, 1, h); }
  const char* name() const override { return "bullet_deformable"; }

  Parts parts_;
  btDeformableBodySolver body_solver_;
  btDeformableMultiBodyConstraintSolver solver_;
  btDeformableMultiBodyDynamicsWorld world_{&parts_.dispatcher, &parts_.broadphase, &solver_,
                                            &parts_.configuration, &body_solver_};
  std::unique_ptr<btDeformableMassSpringForce> springs_;
  std::unique_ptr<btDeformableGravityForce> gravity_;
};

}  // namespace

StepperMaker bullet(const Scene& scene, BulletWorld world, int substeps, int iterations,
                    bool matched) {
  return [=]() -> std::unique_ptr<Stepper> {
    if (world == BulletWorld::springs) return std::make_unique<SpringCloth>(scene, substeps);
    return std::make_unique<PositionCloth>(scene, substeps, iterations, matched);
  };
}

}  // namespace clothsim::work_precision
