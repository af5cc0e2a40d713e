// The robot that tool0 drives.

#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include <gazebo/physics/ode/ode_inc.h>
#include <gazebo/physics/physics.hh>

#include "drive.h"
#include "entities.h"
#include "gears.h"
#include "protocol.h"

namespace tool0 {

using ignition::math::Pose3d;

/// The robot's model with its drives, gears and racks; empty until Bind.
class Robot {
 public:
  const gazebo::physics::ModelPtr& Model() const { return model_; }

  /// Takes over a model of the world; see kBind.
  void Bind(Packet& packet, const gazebo::physics::WorldPtr& world, double dt) {
    const auto model = FindModel(world, packet.TakeText());
    std::vector<Drive> drives;
    for (auto n = packet.Take<std::uint32_t>(); n > 0; --n) {
      const std::string name = packet.TakeText();
      const auto joint = model->GetJoint(name);
      if (!joint)
        throw std::runtime_error("Gazebo's model has no joint '" + name + "'");
      const double armature = packet.Take<double>();
      drives.emplace_back(joint);
      if (armature > 0.0) {
        joint->SetEffortLimit(0, -1.0);  // both are left to tool0's drives
        joint->SetVelocityLimit(0, -1.0);
        drives.back().AddArmature(armature, dt, OdeWorld(world));
      }
    }
    std::vector<Gear> gears;
    std::vector<Rack> racks;
    for (auto g = packet.Take<std::uint32_t>(); g > 0; --g) {
      const Drive* second = &drives.at(packet.Take<std::uint32_t>());
      const Drive* first = &drives.at(packet.Take<std::uint32_t>());
      const double multiplier = packet.Take<double>();
      if (first->turns) gears.push_back({first, second, multiplier});
      else racks.emplace_back(first, second, multiplier, OdeWorld(world));
    }
    poses_at_zero_.clear();
    for (const auto& link : model->GetLinks())
      poses_at_zero_.emplace_back(link, link->WorldPose());
    drives_.swap(drives);
    gears_.swap(gears);
    racks_.swap(racks);
    model_ = model;
  }

  void ApplyEfforts(Packet& packet) {
    for (Drive& drive : drives_) drive.ApplyEffort(packet.Take<double>());
  }

  void SetBrakes(Packet& packet, const gazebo::physics::WorldPtr& world) {
    for (Drive& drive : drives_) drive.SetBrake(packet.Take<double>(), OdeWorld(world));
  }

  /// Makes the teeth of gears and racks mesh in the next step.
  void UpdateTeeth(const gazebo::physics::WorldPtr& world, double dt) const {
    if (gears_.empty() && racks_.empty()) return;
    const dWorldID ode = OdeWorld(world);
    RemoveTeeth();
    for (const Gear& gear : gears_) gear.AddConstraint(ode, teeth_, dt);
    for (const Rack& rack : racks_) rack.AddConstraint(ode, teeth_, dt);
  }
  void RemoveTeeth() const { dJointGroupEmpty(teeth_); }

  /// Places the joints at rest.  In: position of each joint, pose of each joint's child link.
  void Reset(Packet& packet) {
    // From where all joints are at zero, since ODE takes the shorter way to an angle.
    for (const auto& [link, pose] : poses_at_zero_) Place(link, pose);
    for (const Drive& drive : drives_) drive.joint->Position(0);
    for (Drive& drive : drives_) drive.position = packet.Take<double>();
    for (const Drive& drive : drives_) Place(drive.child, packet.TakePose());
    for (const Rack& rack : racks_) rack.Place();
  }

  /// Measures, and puts the position [rad | m] of each joint, then each velocity.
  void PutState(Packet& packet) {
    for (Drive& drive : drives_) drive.Measure(), packet.Put(drive.position);
    for (const Drive& drive : drives_) packet.Put(drive.velocity);
  }
  /// Puts NaN in place of each position and velocity.
  void PutNoState(Packet& packet) const {
    for (std::size_t n = 2 * drives_.size(); n > 0; --n)
      packet.Put(std::numeric_limits<double>::quiet_NaN());
  }

  /// Returns the first joint whose child link is in this model and is not finite, or null.
  gazebo::physics::JointPtr LostJoint(const gazebo::physics::ModelPtr& model) const {
    for (const Drive& drive : drives_)
      if (drive.child->GetModel() == model && !IsFinite(drive.child)) return drive.joint;
    return nullptr;
  }

 private:
  gazebo::physics::ModelPtr model_;
  std::vector<Drive> drives_;
  std::vector<Gear> gears_;
  std::vector<Rack> racks_;
  std::vector<std::pair<gazebo::physics::LinkPtr, Pose3d>> poses_at_zero_;
  const dJointGroupID teeth_ = dJointGroupCreate(0);
};

}  // namespace tool0
