// The packets of the bridge, and its requests.
//
// Packets are native: both ends are one machine.  A request begins with its kind as
// uint32; an answer with 0, or with 1 and then says what is wrong.  Kind lists the rest of
// each request.  When the bridge connects, it sends `uint32 version, text of Gazebo's
// version`, and receives `uint32 version, double dt`.  kVersion is raised whenever any of
// this changes.

#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <stdexcept>
#include <string>

#include <ignition/math/Pose3.hh>
#include <ignition/math/Vector3.hh>

namespace tool0 {

using ignition::math::Pose3d;
using ignition::math::Vector3d;

constexpr std::uint32_t kVersion = 8;
constexpr std::size_t kMaxPacket = 1 << 16;  // [bytes]

/// Poses are in the world [m, quaternion w x y z].  A text ends with a zero byte.
enum Kind : std::uint32_t {
  /// In: effort of each joint [N·m | N].  Out: position [rad | m] of each joint, then
  /// velocity of each joint.  If a joint or an object is not finite: NaN in place of all
  /// these numbers, then "joint " or "object " and its name.
  kStep = 1,
  /// Places joints and objects at rest.  In: time [s], position of each joint, pose of each
  /// joint's child link, pose of each object.  Out: see kStep.
  kReset,
  /// In: name of the robot, with all joints at zero; n; of each joint its name and
  /// armature [kg·m²]; g; of each gear or rack the numbers of its second and first
  /// joint, and its multiplier.  Out: the world's gravity [m/s²].
  kBind,
  /// Out: of each object, in the order in which they were added, its pose, the velocity of
  /// its origin [m/s], its angular velocity [rad/s].
  kObjects,
  /// In: name, file of the URDF or SDF, pose, whether it is an object as uint32.
  kSpawn,
  /// In: name of a model, not the robot's.
  kDelete,
  /// In: name of an object, pose, velocity of its origin [m/s], angular velocity [rad/s].
  kPlace,
  /// In: number of contacts that are known from earlier answers.  Out: number of contacts in
  /// this answer, number of contacts left; of each pair of shapes that touched in the last
  /// step, the names of the first shape's model and of the first shape, the same names of
  /// the second shape, and the numbers of a ContactSum.  The first request only starts the
  /// recording.  Each attached object is reported in the same way, with the names of the
  /// robot, of the link that holds the object, and of the object, and an empty name.
  kContacts,
  /// Fixes an object in its current pose.  In: name of a movable object, name of the robot's
  /// link that holds the object (empty if the link never moves), name of this link in the
  /// URDF.
  kAttach,
  /// In: name of an object, attached or not.
  kDetach,
  /// In: name of a model, name of a link in it.  Out: where the link has its centre of
  /// mass, in the world [m].
  kCenter,
  /// In: n; of each wrench that acts from now on its link, see kCenter, force [N] and
  /// torque [N·m].
  kWrenches,
  /// In: torque of each joint's brake [N·m | N], 0 for one that is released.
  kBrakes
};

/// A packet that is being read or written, piece by piece.
class Packet {
 public:
  void Clear() { size_ = at_ = 0; }
  void BeginAnswer() { Clear(), Put(std::uint32_t{0}); }
  void PutError(const std::string& why) { Clear(), Put(std::uint32_t{1}), Put(why); }
  char* Buffer() { return bytes_; }
  void Fill(std::size_t size) { size_ = size, at_ = 0; }
  const char* Bytes() const { return bytes_; }
  std::size_t Size() const { return size_; }
  std::size_t Left() const { return kMaxPacket - size_; }

  template <typename T>
  void Put(const T& value) {
    if (size_ + sizeof value > kMaxPacket) throw std::runtime_error("answer too long");
    std::memcpy(bytes_ + size_, &value, sizeof value);
    size_ += sizeof value;
  }
  void Put(const std::string& text) {
    const std::size_t n = std::min(text.size(), kMaxPacket - size_);
    std::memcpy(bytes_ + size_, text.data(), n);
    size_ += n;
  }
  /// Puts a number where another one is.
  void Overwrite(std::size_t at, std::uint32_t value) {
    std::memcpy(bytes_ + at, &value, sizeof value);
  }
  void PutText(const std::string& text) {
    Put(text);
    Put('\0');
  }
  void Put(const Pose3d& pose) {
    for (double x : {pose.Pos().X(), pose.Pos().Y(), pose.Pos().Z(), pose.Rot().W(),
                     pose.Rot().X(), pose.Rot().Y(), pose.Rot().Z()})
      Put(x);
  }
  void Put(const Vector3d& vector) {
    for (double x : {vector.X(), vector.Y(), vector.Z()}) Put(x);
  }

  template <typename T>
  T Take() {
    T value;
    if (at_ + sizeof value > size_) throw std::runtime_error("request too short");
    std::memcpy(&value, bytes_ + at_, sizeof value);
    at_ += sizeof value;
    return value;
  }
  /// A text that ends with a zero byte.
  std::string TakeText() {
    const void* end = std::memchr(bytes_ + at_, 0, size_ - at_);
    if (!end) throw std::runtime_error("text without end");
    const std::string text(bytes_ + at_, static_cast<const char*>(end) - bytes_ - at_);
    at_ += text.size() + 1;
    return text;
  }
  Pose3d TakePose() {
    double v[7];
    for (double& x : v) x = Take<double>();
    return Pose3d(v[0], v[1], v[2], v[3], v[4], v[5], v[6]);
  }
  Vector3d TakeVector() {
    double v[3];
    for (double& x : v) x = Take<double>();
    return Vector3d(v[0], v[1], v[2]);
  }

 private:
  char bytes_[kMaxPacket];
  std::size_t size_ = 0, at_ = 0;
};

}  // namespace tool0
