// The contacts of a step.

#pragma once

#include <dlfcn.h>

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include <gazebo/physics/ode/ode_inc.h>
#include <gazebo/physics/physics.hh>

#include "entities.h"
#include "protocol.h"

namespace tool0 {

using ignition::math::Vector3d;

/// What the points of contact between two shapes add up to, in the world.
struct ContactSum {
  // A shape that is kept while its model goes would still bump into others.
  boost::weak_ptr<gazebo::physics::Collision> first, second;
  double weight = 0.0;  // how hard all points press [N]
  Vector3d moment;      // of the points, by how hard each presses [N·m]
  Vector3d force, torque;  // that the first exerts on the second, about the origin

  /// Returns both shapes, or nothing if somebody has deleted one of them.
  std::pair<gazebo::physics::CollisionPtr, gazebo::physics::CollisionPtr> Shapes() const {
    const auto one = first.lock(), other = second.lock();
    if (!one || !other || !one->GetLink() || !other->GetLink()) return {};
    return {one, other};
  }
};

/// The part of the contacts that fits into one answer; see kContacts.
class ContactAnswer {
 public:
  /// Begins an answer that leaves out the first `known` contacts.
  ContactAnswer(Packet& packet, std::uint32_t known) : packet_(packet), known_(known) {
    packet_.BeginAnswer();
    at_ = packet_.Size();
    packet_.Put(told_), packet_.Put(left_);
  }

  /// Adds a contact: the names of both models and shapes, and the numbers of a ContactSum.
  void Add(const std::array<std::string, 4>& words, double weight,
           const std::array<Vector3d, 3>& vectors) {
    if (all_++ < known_) return;
    std::size_t size = 10 * sizeof(double);
    for (const auto& word : words) size += word.size() + 1;
    if (left_ > 0 || size > packet_.Left()) return void(++left_);
    for (const auto& word : words) packet_.PutText(word);
    packet_.Put(weight);
    for (const auto& vector : vectors) packet_.Put(vector);
    ++told_;
  }

  /// Puts the counts where the constructor left room for them.
  void Finish() {
    packet_.Overwrite(at_, told_);
    packet_.Overwrite(at_ + sizeof told_, left_);
  }

 private:
  Packet& packet_;
  const std::uint32_t known_;
  std::size_t at_;  // of both counts
  std::uint32_t all_ = 0, told_ = 0, left_ = 0;
};

/// Every contact that ODE makes, from when it is first asked for.
class ContactRecorder {
 public:
  bool IsOn() const { return *Hook(); }
  void SwitchOn() { *Hook() = [](dJointID j, const dContactGeom* g) { Record(j, *g); }; }
  void Clear() { points_.clear(), sums_.clear(); }
  void BeginStep() { points_.clear(); }

  void Put(ContactAnswer& answer) const {
    for (const ContactSum& touch : sums_) {
      const auto [first, second] = touch.Shapes();
      if (!first) continue;
      answer.Add({first->GetModel()->GetName(), first->GetName(),
                  second->GetModel()->GetName(), second->GetName()},
                 touch.weight, {touch.moment, touch.force, touch.torque});
    }
  }

  /// Adds up the points of the step that was made, while their shapes are still there.
  /// What sleeps has none, and lies as it lay.
  void AddUp() {
    const auto is_over = [](const ContactSum& touch) {
      const auto [first, second] = touch.Shapes();
      return !first || IsAwake(first) || IsAwake(second);
    };
    sums_.erase(std::remove_if(sums_.begin(), sums_.end(), is_over), sums_.end());
    for (const Point& point : points_) Add(point);
    points_.clear();
  }

 private:
  struct Point {
    dJointID joint;
    dContactGeom geom;
    dJointFeedback feedback;  // unless Gazebo wants to have one itself
  };
  using ContactCallback = void (*)(dJointID, const dContactGeom*);

  /// In the preloaded library, see preload.cc.
  static ContactCallback* Hook() {
    static const auto hook =
        static_cast<ContactCallback*>(::dlsym(RTLD_DEFAULT, "tool0_touched"));
    if (!hook) throw std::runtime_error("the preloaded library is missing");
    return hook;
  }

  static void Record(dJointID joint, const dContactGeom& geom) {
    if (!geom.g1 || !geom.g2) return;  // teeth
    points_.push_back({joint, geom, {}});
    dJointSetFeedback(joint, &points_.back().feedback);
  }

  void Add(const Point& point) {
    const dJointFeedback* felt = dJointGetFeedback(point.joint);
    // ODE tells what acts on the first body, and puts one that there is first.
    const bool is_first = dJointGetBody(point.joint, 0);
    if (!felt || !(is_first || dJointGetBody(point.joint, 1))) return;
    const Vector3d at = From(point.geom.pos);
    const Vector3d force = From(felt->f1) * (is_first ? -1.0 : 1.0);
    const double press = -force.Dot(From(point.geom.normal));  // which points into the first
    if (!(press > 0.0)) return;
    ContactSum& sum = Between(Shape(point.geom.g1), Shape(point.geom.g2));
    sum.weight += press;
    sum.moment += at * press;
    sum.force += force;
    sum.torque += at.Cross(force);
  }

  ContactSum& Between(const gazebo::physics::CollisionPtr& first,
                      const gazebo::physics::CollisionPtr& second) {
    for (ContactSum& sum : sums_)
      if (sum.Shapes() == std::make_pair(first, second)) return sum;
    sums_.push_back({first, second});
    return sums_.back();
  }

  static bool IsAwake(const gazebo::physics::CollisionPtr& shape) {
    const dBodyID body = BodyOf(shape->GetLink());
    return body && dBodyIsEnabled(body);
  }
  static gazebo::physics::CollisionPtr Shape(dGeomID geom) {
    const auto shape = static_cast<gazebo::physics::Collision*>(dGeomGetData(geom));
    return boost::static_pointer_cast<gazebo::physics::Collision>(
        shape->shared_from_this());
  }
  static inline std::deque<Point> points_;  // which stay where they are, for ODE
  std::vector<ContactSum> sums_;
};

}  // namespace tool0
