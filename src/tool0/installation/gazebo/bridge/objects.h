// The objects of the scene, and what holds them.

#pragma once

#include <algorithm>
#include <map>
#include <stdexcept>
#include <string>
#include <vector>

#include <gazebo/physics/ode/ode_inc.h>
#include <gazebo/physics/physics.hh>

#include "contacts.h"
#include "entities.h"
#include "protocol.h"

namespace tool0 {

using ignition::math::Vector3d;

/// An object that is fixed to a link, and what holds it.
struct Attached {
  dJointID joint;
  std::string link;  // as the URDF has it
  dJointFeedback feedback;
};

/// The models that were added as objects, in this order.
class Objects {
 public:
  void Add(const gazebo::physics::ModelPtr& object) { objects_.push_back(object); }

  bool Has(const std::string& name) const {
    return std::any_of(objects_.begin(), objects_.end(), HasName{name});
  }

  /// Detaches and forgets the object of a name, if there is one.
  void Remove(const std::string& name) {
    Detach(name);
    const auto gone = std::remove_if(objects_.begin(), objects_.end(), HasName{name});
    objects_.erase(gone, objects_.end());
  }

  /// Puts the poses and velocities; see kObjects.
  void Put(Packet& packet) const {
    for (const auto& object : objects_) {
      const auto link = Exists(object) ? object->GetLinks().front() : nullptr;
      packet.Put(object->WorldPose());
      packet.Put(link ? link->WorldLinearVel() : Vector3d::Zero);
      packet.Put(link ? link->WorldAngularVel() : Vector3d::Zero);
    }
  }

  /// Places the objects at rest.  In: pose of each object.
  void Reset(Packet& packet) const {
    for (const auto& object : objects_) {
      const auto pose = packet.TakePose();
      if (Exists(object)) Place(object, pose);
    }
  }

  /// Sets an object's pose and velocity; see kPlace.
  void Move(Packet& packet, const gazebo::physics::WorldPtr& world) {
    const auto object = FindModel(world, packet.TakeText());
    Detach(object->GetName());
    Place(object, packet.TakePose());
    const auto link = object->GetLinks().front();
    const auto center = link->WorldCoGPose().Pos() - link->WorldPose().Pos();
    const auto linear = packet.TakeVector(), angular = packet.TakeVector();
    link->SetLinearVel(linear + angular.Cross(center));  // ODE's is the centre's
    link->SetAngularVel(angular);
    world->EnableAllModels();  // what slept on it would stay in the air
  }

  /// Fixes an object to a link of the robot; see kAttach.
  void Attach(Packet& packet, const gazebo::physics::WorldPtr& world,
              const gazebo::physics::ModelPtr& robot) {
    const auto object = FindModel(world, packet.TakeText());
    const std::string name = packet.TakeText();
    const std::string called = packet.TakeText();
    const auto link = name.empty() ? nullptr : robot->GetLink(name);
    if (!name.empty() && !link)
      throw std::runtime_error("Gazebo's robot has no link '" + name + "'");
    if (!Exists(object))
      throw std::runtime_error("somebody deleted '" + object->GetName() + "'");
    if (const auto found = attached_.find(object->GetName()); found != attached_.end()) {
      if (dJointGetBody(found->second.joint, 0))
        throw std::runtime_error("'" + found->first + "' is attached already");
      Detach(found->first);  // of one that had the name, and that somebody deleted
    }
    const dBodyID body = BodyOf(object->GetLinks().front());
    const dJointID joint = dJointCreateFixed(OdeWorld(world), 0);
    dJointAttach(joint, body, link ? BodyOf(link) : nullptr);
    dJointSetFixed(joint);
    dBodyEnable(body);
    Attached& attached = attached_[object->GetName()] = {joint, called, {}};
    dJointSetFeedback(joint, &attached.feedback);
  }

  /// Detaches an object, which may be free or deleted.
  void Detach(const std::string& name) {
    const auto found = attached_.find(name);
    if (found == attached_.end()) return;
    const dJointID joint = found->second.joint;
    if (const dBodyID body = dJointGetBody(joint, 0)) dBodyEnable(body);
    dJointDestroy(joint);
    attached_.erase(found);
  }
  void DetachAll() {
    while (!attached_.empty()) Detach(attached_.begin()->first);
  }

  /// Adds the forces that hold attached objects, as contacts of the robot's links.
  void PutHeld(ContactAnswer& answer, const gazebo::physics::ModelPtr& robot) const {
    for (const auto& [name, attached] : attached_) {
      const dBodyID body = dJointGetBody(attached.joint, 0);
      const Vector3d force = From(attached.feedback.f1);
      const double weight = force.Length();
      if (!body || !(weight > 0.0)) continue;
      const Vector3d center = From(dBodyGetPosition(body));
      answer.Add({robot->GetName(), attached.link, name, ""}, weight,
                 {center * weight, force, From(attached.feedback.t1) + center.Cross(force)});
    }
  }

 private:
  struct HasName {
    const std::string& name;
    bool operator()(const gazebo::physics::ModelPtr& object) const {
      return object->GetName() == name;
    }
  };

  std::vector<gazebo::physics::ModelPtr> objects_;
  std::map<std::string, Attached> attached_;  // by the object's name
};

}  // namespace tool0
