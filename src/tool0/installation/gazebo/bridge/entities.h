// Models and links of Gazebo's world, and the bodies of ODE behind them.

#pragma once

#include <algorithm>
#include <cmath>
#include <numeric>
#include <stdexcept>
#include <string>

#include <gazebo/physics/ode/ODELink.hh>
#include <gazebo/physics/ode/ODEPhysics.hh>
#include <gazebo/physics/ode/ODESurfaceParams.hh>
#include <gazebo/physics/ode/ode_inc.h>
#include <gazebo/physics/physics.hh>

#include "protocol.h"

namespace tool0 {

using ignition::math::Pose3d;
using ignition::math::Vector3d;

constexpr double kFrictionSlip = 1e-7;  // [m/s/N]; see AddFrictionSlip

inline Vector3d From(const dReal* v) { return Vector3d(v[0], v[1], v[2]); }

inline dWorldID OdeWorld(const gazebo::physics::WorldPtr& world) {
  return static_cast<gazebo::physics::ODEPhysics*>(world->Physics().get())->GetWorldId();
}

/// Returns the body of a link, or null if it stands still for ever.
inline dBodyID BodyOf(const gazebo::physics::LinkPtr& link) {
  return static_cast<gazebo::physics::ODELink*>(link.get())->GetODEId();
}

/// Returns whether ODE knows where the link is and how it moves.  What turned too fast for
/// a number it leaves with a quaternion that is zero.
inline bool IsFinite(const gazebo::physics::LinkPtr& link) {
  const dBodyID body = BodyOf(link);
  if (!body) return true;
  double sum = 0.0;
  for (const auto values :
       {dBodyGetPosition(body), dBodyGetLinearVel(body), dBodyGetAngularVel(body)})
    sum += values[0] + values[1] + values[2];
  const dReal* q = dBodyGetQuaternion(body);
  return std::isfinite(sum) && std::inner_product(q, q + 4, q, 0.0) > 0.5;
}

/// Returns whether nobody else deleted the object, which leaves it without links.
inline bool Exists(const gazebo::physics::ModelPtr& object) {
  return !object->GetLinks().empty();
}

inline gazebo::physics::ModelPtr FindModel(const gazebo::physics::WorldPtr& world,
                                           const std::string& name) {
  const auto model = world->ModelByName(name);
  if (!model) throw std::runtime_error("the world has no model '" + name + "'");
  return model;
}

/// In: name of a model, name of a link in it.
inline gazebo::physics::LinkPtr TakeLink(Packet& packet,
                                         const gazebo::physics::WorldPtr& world) {
  const auto model = FindModel(world, packet.TakeText());
  const std::string name = packet.TakeText();
  const auto link = model->GetLink(name);
  if (!link)
    throw std::runtime_error("Gazebo's '" + model->GetName() + "' has no link '" + name + "'");
  return link;
}

/// Puts a model or a link somewhere, at rest.
inline void Place(const gazebo::physics::EntityPtr& entity, const Pose3d& pose) {
  entity->SetWorldPose(pose);
  if (const auto model = boost::dynamic_pointer_cast<gazebo::physics::Model>(entity))
    model->ResetPhysicsStates();
  else if (const auto link = boost::dynamic_pointer_cast<gazebo::physics::Link>(entity))
    link->ResetPhysicsStates();
}

/// Lets friction yield a little.  Two flat faces touch in more points than it takes to
/// hold them, and ODE's direct solver gives up on rows that say the same.
inline void AddFrictionSlip(const gazebo::physics::ModelPtr& model) {
  for (const auto& link : model->GetLinks())
    for (const auto& collision : link->GetCollisions()) {
      const auto surface = boost::dynamic_pointer_cast<gazebo::physics::ODESurfaceParams>(
          collision->GetSurface());
      if (!surface) continue;
      surface->slip1 = std::max(surface->slip1, kFrictionSlip);
      surface->slip2 = std::max(surface->slip2, kFrictionSlip);
    }
}

}  // namespace tool0
