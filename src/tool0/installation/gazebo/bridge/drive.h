// The drive of a joint.

#pragma once

#include <cmath>
#include <utility>

#include <gazebo/physics/ode/ode_inc.h>
#include <gazebo/physics/physics.hh>

#include "entities.h"

namespace tool0 {

using ignition::math::Quaterniond;
using ignition::math::Vector3d;

constexpr double kBrakeCfm = 1e-10;  // [rad/s/(N·m)]; see Drive

/// A joint of the robot, at zero when it is made, with what Gazebo's own lacks: full turns,
/// armature, and a brake.
///
/// An armature A resists by -A (v' - v) / dt, where v' is the velocity after the step, and a
/// damping D by -D v'.  Both are a motor of ODE's, beside the joint, that wants the velocity
/// v A / (A + D dt), is as strong as it takes, but yields by dt / (A + D dt).  Gazebo's own
/// damper of the joint could do the same, but not at a stop, where it ceases.
///
/// A brake is such a motor, too: it wants the joint to stand, with at most its torque.  It
/// yields a little, since a joint at its stop would have two constraints for one motion.
class Drive {
 public:
  explicit Drive(gazebo::physics::JointPtr its)
      : joint(std::move(its)),
        child(joint->GetChild()),
        turns(joint->HasType(gazebo::physics::Base::HINGE_JOINT)),
        above(joint->GetParent() ? BodyOf(joint->GetParent()) : nullptr),
        below(BodyOf(child)),
        back(Relative().Inverse()),
        axis(Orientation(below).RotateVectorReverse(joint->GlobalAxis(0))) {}

  gazebo::physics::JointPtr joint;
  gazebo::physics::LinkPtr child;
  bool turns;  // whether the angle wraps at ±π
  double position = 0.0, velocity = 0.0;

  /// Not by the angle that ODE adds up, in which every earlier one has left its rounding.
  void Measure() {
    if (turns) {
      const Quaterniond turned = back * Relative();
      const Vector3d sine(turned.X(), turned.Y(), turned.Z());
      const double angle = 2.0 * std::atan2(axis.Dot(sine), turned.W());
      position += std::remainder(angle - position, 2.0 * M_PI);
    } else {
      position = joint->Position(0);
    }
    velocity = turns ? joint->GetVelocity(0) : Speed();
  }
  void ApplyEffort(double effort) {
    joint->SetForce(0, effort);
    if (motor_) Set(motor_, dParamVel, velocity_gain_ * Speed());
  }
  /// Engages the brake with a torque [N·m | N]; releases it if that is 0.
  void SetBrake(double torque, dWorldID world) {
    if (!brake_ && torque > 0.0) {
      brake_ = MakeMotor(world);
      Set(brake_, dParamCFM, kBrakeCfm);
    }
    if (brake_) Set(brake_, dParamFMax, torque);
  }
  /// Adds an armature [kg·m² | kg], and takes over the joint's damping.
  void AddArmature(double armature, double dt, dWorldID world) {
    const double inert = armature / dt, all = inert + joint->GetDamping(0);
    joint->SetDamping(0, 0.0);
    velocity_gain_ = inert / all;
    motor_ = MakeMotor(world);
    Set(motor_, dParamFMax, dInfinity);
    Set(motor_, dParamCFM, 1.0 / all);
  }

 private:
  dBodyID above, below;  // of the parent, which may be none, and of the child
  Quaterniond back;      // from how the child is turned in its parent, at zero
  Vector3d axis;         // in the child
  dJointID motor_ = nullptr, brake_ = nullptr;
  double velocity_gain_ = 1.0;  // of the velocity, in a step
  static constexpr int kOfFirstBody = 1;

  /// Returns a motor of ODE's along the joint, without any strength.
  dJointID MakeMotor(dWorldID world) const {
    const dJointID motor = turns ? dJointCreateAMotor(world, 0) : dJointCreateLMotor(world, 0);
    dJointAttach(motor, below, above);
    const Vector3d along = joint->GlobalAxis(0);
    (turns ? dJointSetAMotorNumAxes : dJointSetLMotorNumAxes)(motor, 1);
    (turns ? dJointSetAMotorAxis : dJointSetLMotorAxis)(
        motor, 0, kOfFirstBody, along.X(), along.Y(), along.Z());
    return motor;
  }
  void Set(dJointID motor, int parameter, double value) const {
    (turns ? dJointSetAMotorParam : dJointSetLMotorParam)(motor, parameter, value);
  }
  /// Returns the joint's velocity.  ODE's own of a slider is wrong while its parent turns:
  /// it compares the centres of both bodies.
  double Speed() const {
    const Vector3d along = joint->GlobalAxis(0);
    const double apart = along.Dot(Velocity(below)) - along.Dot(Velocity(above));
    if (turns || !above) return apart;
    const dReal *from = dBodyGetPosition(above), *to = dBodyGetPosition(below);
    const Vector3d lever(to[0] - from[0], to[1] - from[1], to[2] - from[2]);
    const dReal* w = dBodyGetAngularVel(above);
    return apart - along.Dot(Vector3d(w[0], w[1], w[2]).Cross(lever));
  }
  /// Returns how fast a body turns, or its centre moves.
  Vector3d Velocity(dBodyID body) const {
    if (!body) return Vector3d::Zero;
    const dReal* v = turns ? dBodyGetAngularVel(body) : dBodyGetLinearVel(body);
    return Vector3d(v[0], v[1], v[2]);
  }

  /// What has no body stands still, turned as it may be.
  static Quaterniond Orientation(dBodyID body) {
    if (!body) return Quaterniond::Identity;
    const dReal* q = dBodyGetQuaternion(body);
    return Quaterniond(q[0], q[1], q[2], q[3]);
  }
  Quaterniond Relative() const { return Orientation(above).Inverse() * Orientation(below); }
};

}  // namespace tool0
