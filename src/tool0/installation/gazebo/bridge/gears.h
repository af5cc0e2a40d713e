// Couplings of two joints, which Gazebo's own joints lack.

#pragma once

#include <gazebo/physics/ode/ode_inc.h>
#include <gazebo/physics/physics.hh>

#include "drive.h"
#include "entities.h"

namespace tool0 {

using ignition::math::Pose3d;
using ignition::math::Vector3d;

constexpr double kGearErp = 0.2;  // of an error, undone in a step

/// Teeth between two joints whose axes are parallel and sit on one body: the second
/// moves as far as the multiplier times the first.
///
/// They mesh where both axes' velocities agree, on the line that joins them: a contact
/// of ODE without a normal force, whose friction along the tangent knows no bound.
struct Gear {
  const Drive* first;
  const Drive* second;
  double multiplier;

  void AddConstraint(dWorldID world, dJointGroupID group, double dt) const {
    const auto axis = first->joint->GlobalAxis(0);
    const double turn = axis.Dot(second->joint->GlobalAxis(0)) < 0.0 ? -1.0 : 1.0;
    const auto from = first->joint->Anchor(0);
    auto apart = second->joint->Anchor(0) - from;
    apart -= axis * axis.Dot(apart);
    const double length = apart.Length();
    const double share = multiplier * turn / (multiplier * turn - 1.0);
    const double error = second->position - multiplier * first->position;
    dContact contact{};
    Set(contact.geom.pos, from + apart * share);
    Set(contact.geom.normal, apart / length);
    Set(contact.fdir1, axis.Cross(apart) / length);
    contact.surface.mode = dContactMu2 | dContactFDir1 | dContactMotion1 | dContactMotionN;
    contact.surface.mu = dInfinity;
    contact.surface.mu2 = 0.0;
    contact.surface.motionN = -10.0;  // [m/s], so that the normal row never acts
    contact.surface.motion1 = kGearErp * error / dt * turn * (share - 1.0) * length;
    dJointAttach(dJointCreateContact(world, group, &contact), Body(*first), Body(*second));
  }

 private:
  static void Set(dReal* to, const Vector3d& from) {
    for (int i : {0, 1, 2}) to[i] = from[i];
  }
  static dBodyID Body(const Drive& drive) { return BodyOf(drive.child); }
};

/// Two joints that slide along parallel axes on one body, the carrier: the second moves as
/// far as the multiplier times the first.
///
/// Each carries a rack, and both racks mesh with a pinion that turns on the carrier.  The
/// teeth are those of Gear.  Gazebo does not know the pinion; it is so light that it only
/// hands on forces.
class Rack {
 public:
  Rack(const Drive* first, const Drive* second, double multiplier, dWorldID world)
      : first_(first), second_(second), multiplier_(multiplier),
        carrier_(first->joint->GetParent()), pinion_(dBodyCreate(world)),
        pivot_(dJointCreateHinge(world, 0)) {
    dMass mass;
    dMassSetSphereTotal(&mass, kMass, kRadius);
    dBodySetMass(pinion_, &mass);
    dBodySetGravityMode(pinion_, 0);
    dBodySetAutoDisableFlag(pinion_, 0);
    const auto along = first->joint->GlobalAxis(0);
    const auto other = second->joint->GlobalAxis(0);
    side_ = along.Dot(other) < 0.0 ? -1.0 : 1.0;
    const auto carrier = Carrier();
    along_ = carrier.Rot().RotateVectorReverse(along);
    axis_ = along_.Perpendicular().Normalized();
    center_ = carrier.Inverse().CoordPositionAdd(
        (first->child->WorldPose().Pos() + second->child->WorldPose().Pos()) / 2.0);
    Place();
    dJointAttach(pivot_, pinion_, carrier_ ? BodyOf(carrier_) : nullptr);
    const auto at = From(dBodyGetPosition(pinion_));
    const auto turns = carrier.Rot() * axis_;
    dJointSetHingeAnchor(pivot_, at.X(), at.Y(), at.Z());
    dJointSetHingeAxis(pivot_, turns.X(), turns.Y(), turns.Z());
  }

  /// Puts the pinion where it belongs, at rest.
  void Place() const {
    const auto carrier = Carrier();
    const auto at = carrier.CoordPositionAdd(center_);
    dBodySetPosition(pinion_, at.X(), at.Y(), at.Z());
    const dQuaternion q = {carrier.Rot().W(), carrier.Rot().X(), carrier.Rot().Y(),
                           carrier.Rot().Z()};
    dBodySetQuaternion(pinion_, q);
    dBodySetLinearVel(pinion_, 0.0, 0.0, 0.0);
    dBodySetAngularVel(pinion_, 0.0, 0.0, 0.0);
  }

  void AddConstraint(dWorldID world, dJointGroupID group, double dt) const {
    const double error = second_->position - multiplier_ * first_->position;
    const auto along = first_->joint->GlobalAxis(0);
    AddTeeth(world, group, *first_, along, kRadius, 0.0);
    AddTeeth(world, group, *second_, along, side_ * multiplier_ * kRadius,
             -kGearErp * error / dt * side_);
  }

 private:
  static constexpr double kRadius = 0.01;  // [m]
  static constexpr double kMass = 0.005;   // [kg]
  const Drive* first_;
  const Drive* second_;
  double multiplier_, side_;
  gazebo::physics::LinkPtr carrier_;  // none: the world
  dBodyID pinion_;
  dJointID pivot_;
  Vector3d along_, axis_, center_;  // in the carrier

  Pose3d Carrier() const {
    return carrier_ ? carrier_->WorldPose() : Pose3d::Zero;
  }

  /// Holds a rack against the pinion at a radius, so that it moves by `speed` [m/s] along
  /// `along` past the pinion's teeth.
  void AddTeeth(dWorldID world, dJointGroupID group, const Drive& rack,
                const Vector3d& along, double radius, double speed) const {
    const auto turns = Carrier().Rot() * axis_;
    const auto out = along.Cross(turns);  // where a turn moves the pinion's teeth along
    const auto at = From(dBodyGetPosition(pinion_)) + out * radius;
    dContact contact{};
    for (int i : {0, 1, 2}) {
      contact.geom.pos[i] = at[i];
      contact.geom.normal[i] = out[i];
      contact.fdir1[i] = along[i];
    }
    contact.surface.mode = dContactMu2 | dContactFDir1 | dContactMotion1 | dContactMotionN;
    contact.surface.mu = dInfinity;
    contact.surface.mu2 = 0.0;
    contact.surface.motionN = -10.0;  // [m/s], so that the normal row never acts
    contact.surface.motion1 = speed;
    dJointAttach(dJointCreateContact(world, group, &contact), BodyOf(rack.child), pinion_);
  }
};

}  // namespace tool0
