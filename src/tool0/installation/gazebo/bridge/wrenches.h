// Wrenches that act on links from outside.

#pragma once

#include <cstdint>
#include <vector>

#include <gazebo/physics/ode/ode_inc.h>
#include <gazebo/physics/physics.hh>

#include "entities.h"
#include "protocol.h"

namespace tool0 {

using ignition::math::Vector3d;

/// A force at a link's centre of mass, and a torque, in the axes of the world.
struct Wrench {
  boost::weak_ptr<gazebo::physics::Link> link;  // somebody may delete it
  Vector3d force, torque;

  void Apply() const {
    const auto its = link.lock();
    const dBodyID body = its ? BodyOf(its) : nullptr;
    if (!body) return;
    dBodyEnable(body);
    dBodyAddForce(body, force.X(), force.Y(), force.Z());
    dBodyAddTorque(body, torque.X(), torque.Y(), torque.Z());
  }
};

class Wrenches {
 public:
  /// Replaces all wrenches; see kWrenches.
  void Hold(Packet& packet, const gazebo::physics::WorldPtr& world) {
    std::vector<Wrench> wrenches;
    for (auto n = packet.Take<std::uint32_t>(); n > 0; --n) {
      const auto link = TakeLink(packet, world);
      const auto force = packet.TakeVector(), torque = packet.TakeVector();
      wrenches.push_back({link, force, torque});
    }
    wrenches_.swap(wrenches);
  }
  void Apply() const {
    for (const Wrench& wrench : wrenches_) wrench.Apply();
  }
  void Clear() { wrenches_.clear(); }

 private:
  std::vector<Wrench> wrenches_;
};

}  // namespace tool0
