// The bridge: a plugin of gzserver that hands the clock of the world to tool0.
//
// gzserver loads it beside any world (`gzserver -s`).  It connects to the socket that
// TOOL0_BRIDGE names, a SOCK_SEQPACKET of the Unix kind, and answers requests there:
// one packet in, one packet out.  A step is a request, too: the efforts come in, the
// world makes one step, the new state goes out.  While nothing is asked the world is
// paused, so that gzclient stays alive; when the socket closes, the server ends.
//
// Packets are native: both ends are one machine.  A request begins with its kind as
// uint32; an answer with 0, or with 1 and then says what is wrong.  The rest is listed
// at each request below.  Version is raised whenever any of this changes.

#include <dlfcn.h>
#include <poll.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cerrno>
#include <chrono>
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <deque>
#include <fstream>
#include <functional>
#include <iostream>
#include <limits>
#include <map>
#include <numeric>
#include <sstream>
#include <stdexcept>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include <gazebo/common/Console.hh>
#include <gazebo/common/Events.hh>
#include <gazebo/common/Plugin.hh>
#include <gazebo/gazebo_config.h>
#include <gazebo/msgs/msgs.hh>
#include <gazebo/physics/ode/ODELink.hh>
#include <gazebo/physics/ode/ODEPhysics.hh>
#include <gazebo/physics/ode/ODESurfaceParams.hh>
#include <gazebo/physics/ode/ode_inc.h>
#include <gazebo/physics/physics.hh>
#include <gazebo/transport/transport.hh>

namespace tool0 {

using ignition::math::Pose3d;
using ignition::math::Quaterniond;
using ignition::math::Vector3d;
using Clock = std::chrono::steady_clock;

constexpr std::uint32_t kVersion = 8;
constexpr std::size_t kMaxPacket = 1 << 16;               // [bytes]
constexpr auto kModelTimeout = std::chrono::seconds(10);  // to add or remove a model
constexpr auto kRequestsDone = std::chrono::milliseconds(1500);  // twice, at 5 Hz
constexpr auto kSpinTime = std::chrono::microseconds(60);  // after an answer
constexpr int kIdleAfter = 20;                        // [ms] without a request
constexpr double kIdleRate = 100.0;                   // [Hz] of a paused world's loop
constexpr double kFrictionSlip = 1e-7;                // [m/s/N]; see AddFrictionSlip
constexpr double kBrakeCfm = 1e-10;                   // [rad/s/(N·m)]; see Drive
constexpr double kGearErp = 0.2;                      // of an error, undone in a step
constexpr int kRequest = 1 << 20;                     // Gazebo's own are below 10000

enum Kind : std::uint32_t {
  kStep = 1,
  kReset,
  kBind,
  kObjects,
  kSpawn,
  kDelete,
  kPlace,
  kContacts,
  kAttach,
  kDetach,
  kCenter,
  kWrenches,
  kBrakes
};

/// A packet that is being read or written, piece by piece.
class Packet {
 public:
  void Clear() { size_ = at_ = 0; }
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

/// Returns the body of a link, or null if it stands still for ever.
dBodyID BodyOf(const gazebo::physics::LinkPtr& link) {
  return static_cast<gazebo::physics::ODELink*>(link.get())->GetODEId();
}

/// Returns whether ODE knows where the link is and how it moves.  What turned too fast for
/// a number it leaves with a quaternion that is zero.
bool IsFinite(const gazebo::physics::LinkPtr& link) {
  const dBodyID body = BodyOf(link);
  if (!body) return true;
  double sum = 0.0;
  for (const auto values :
       {dBodyGetPosition(body), dBodyGetLinearVel(body), dBodyGetAngularVel(body)})
    sum += values[0] + values[1] + values[2];
  const dReal* q = dBodyGetQuaternion(body);
  return std::isfinite(sum) && std::inner_product(q, q + 4, q, 0.0) > 0.5;
}

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

Vector3d From(const dReal* v) { return Vector3d(v[0], v[1], v[2]); }

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

  ignition::math::Pose3d Carrier() const {
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

/// An object that is fixed to a link, and what holds it.
struct Attached {
  dJointID joint;
  std::string link;  // as the URDF has it
  dJointFeedback feedback;
};

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

/// Every contact that ODE makes, from when it is first asked for.
class ContactRecorder {
 public:
  bool IsOn() const { return *Hook(); }
  void SwitchOn() { *Hook() = [](dJointID j, const dContactGeom* g) { Record(j, *g); }; }
  void Clear() { points_.clear(), sums_.clear(); }
  void BeginStep() { points_.clear(); }
  const std::vector<ContactSum>& Sums() const { return sums_; }

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

class Bridge : public gazebo::SystemPlugin {
 public:
  ~Bridge() override { ::_exit(0); }  // its threads refer to it

  /// Connects: `uint32 version, text of Gazebo's version` out, `uint32 version,
  /// double dt` in.  Nobody could end a server without a socket, so it ends itself.
  void Load(int, char**) override {
    const char* path = std::getenv("TOOL0_BRIDGE");
    sockaddr_un address{};
    address.sun_family = AF_UNIX;
    if (!path || std::strlen(path) >= sizeof address.sun_path)
      Exit("TOOL0_BRIDGE must name the socket");
    std::strcpy(address.sun_path, path);
    socket_ = ::socket(AF_UNIX, SOCK_SEQPACKET | SOCK_CLOEXEC, 0);
    if (::connect(socket_, reinterpret_cast<sockaddr*>(&address), sizeof address))
      Exit(std::string("cannot connect to ") + path + ": " + std::strerror(errno));
    packet_.Put(kVersion);
    packet_.Put(std::string(GAZEBO_VERSION_FULL));
    SendAnswer();
    if (!Receive(5000)) Exit("nobody answers");
    if (packet_.Take<std::uint32_t>() != kVersion) Exit("wrong version of the bridge");
    dt_ = packet_.Take<double>();
    // A gearbox writes three lines a step into the log file, that it has no angle.
    gazebo::common::Console::log.setstate(std::ios_base::badbit);
    created_ = gazebo::event::Events::ConnectWorldCreated(
        [this](const std::string& name) { OnWorldCreated(name); });
    std::thread([this] { WatchSocket(); }).detach();
  }

 private:
  void OnWorldCreated(const std::string& name) {
    world_ = gazebo::physics::get_world(name);
    world_->SetPaused(false);
    update_ = gazebo::event::Events::ConnectWorldUpdateBegin(
        [this](const gazebo::common::UpdateInfo&) { ServeRequests(); });
    updated_ = gazebo::event::Events::ConnectWorldUpdateEnd([this] { CheckFinite(); });
    node_.reset(new gazebo::transport::Node);
    node_->Init(name);
    requests_ = node_->Advertise<gazebo::msgs::Request>("~/request");
    responses_ = node_->Subscribe("~/response", &Bridge::OnResponse, this);
    has_world_ = true;
  }

  /// Ends the server with the socket; wakes a paused world when something is asked, or
  /// was: anybody may pause it, even in the middle of a step.
  void WatchSocket() {
    for (;;) {
      const bool is_paused = has_world_ && world_->IsPaused();
      pollfd waiting{socket_, static_cast<short>(is_paused ? POLLIN : 0), 0};
      ::poll(&waiting, 1, 10);
      if (waiting.revents & (POLLHUP | POLLERR)) ::_exit(0);
      if (is_paused && (waiting.revents & POLLIN || owes_answer_)) Unpause();
    }
  }

  void Unpause() {
    world_->Physics()->SetRealTimeUpdateRate(0.0);
    world_->SetPaused(false);
  }

  /// Answers requests until one needs the world to go on.
  void ServeRequests() {
    if (!world_->PhysicsEnabled()) Resume();
    if (condition_ && !IsConditionSettled()) return SkipStep();
    if (stepping_) {
      stepping_ = false;
      BeginAnswer();
      PutState();
      SendAnswer();
    }
    for (;;) {
      if (!Receive(kIdleAfter)) return Pause();
      try {
        owes_answer_ = HandleRequest(static_cast<Kind>(packet_.Take<std::uint32_t>()));
        if (stepping_) return;
        if (owes_answer_) return SkipStep();
      } catch (const std::exception& error) {
        PutError(error.what());
      }
      SendAnswer();
    }
  }

  /// Returns whether the world must go on before there is an answer.
  bool HandleRequest(Kind kind) {
    switch (kind) {
      case kStep: return Step();
      case kReset: Reset(); return false;
      case kBind: Bind(); return false;
      case kObjects: Objects(); return false;
      case kSpawn: Spawn(); return true;
      case kDelete: Delete(); return true;
      case kPlace: PlaceObject(); return false;
      case kContacts: Contacts(); return false;
      case kAttach: Attach(); return false;
      case kDetach: Detach(packet_.TakeText()), BeginAnswer(); return false;
      case kCenter: Center(); return false;
      case kWrenches: HoldWrenches(); return false;
      case kBrakes: SetBrakes(); return false;
    }
    throw std::runtime_error("unknown request");
  }

  /// In: effort of each joint [N·m | N].  Out: see PutState.
  bool Step() {
    if (!diverged_.empty()) {
      BeginAnswer();
      PutState();
      return false;
    }
    for (Drive& drive : drives_) drive.ApplyEffort(packet_.Take<double>());
    for (const Wrench& wrench : wrenches_) wrench.Apply();
    UpdateGears();
    contacts_.BeginStep();
    return stepping_ = true;
  }

  /// In: torque of each joint's brake [N·m | N], 0 for one that is released.
  void SetBrakes() {
    for (Drive& drive : drives_) drive.SetBrake(packet_.Take<double>(), Ode());
    BeginAnswer();
  }

  void UpdateGears() {
    if (gears_.empty() && racks_.empty()) return;
    dJointGroupEmpty(gear_joints_);
    for (const Gear& gear : gears_) gear.AddConstraint(Ode(), gear_joints_, dt_);
    for (const Rack& rack : racks_) rack.AddConstraint(Ode(), gear_joints_, dt_);
  }

  dWorldID Ode() const {
    return static_cast<gazebo::physics::ODEPhysics*>(world_->Physics().get())->GetWorldId();
  }

  /// After a step, looks for what is not finite; puts it where it began, and lets
  /// nothing move until the next reset.  At once: ODE adds up what a hinge turns whenever
  /// anybody asks for its angle, and would never forget an angle that is no number.
  void CheckFinite() {
    if (!stepping_) return;
    contacts_.AddUp();
    for (const auto& model : world_->Models()) {
      const auto& links = model->GetLinks();
      const auto lost = std::find_if_not(links.begin(), links.end(), IsFinite);
      if (lost == links.end()) continue;
      if (diverged_.empty()) diverged_ = DivergedName(model);
      const auto pose = model->InitialRelativePose();
      for (const auto& link : links) Place(link, link->InitialRelativePose() + pose);
    }
  }

  /// Returns what of a model is not finite, as the person who reads it knows it.
  std::string DivergedName(const gazebo::physics::ModelPtr& model) const {
    for (const Drive& drive : drives_)
      if (drive.child->GetModel() == model && !IsFinite(drive.child))
        return "joint " + drive.joint->GetName();
    return "object " + model->GetName();
  }

  /// Position [rad | m] of each joint, then velocity; if something is not finite, none
  /// of these is, and what it is follows: "joint " or "object ", and its name.
  void PutState() {
    if (!diverged_.empty()) {
      for (std::size_t n = 2 * drives_.size(); n > 0; --n)
        packet_.Put(std::numeric_limits<double>::quiet_NaN());
      return packet_.Put(diverged_);
    }
    for (Drive& drive : drives_) drive.Measure(), packet_.Put(drive.position);
    for (const Drive& drive : drives_) packet_.Put(drive.velocity);
  }

  /// In: time [s], position of each joint, pose of each joint's child link, pose of each
  /// object.  Puts them there at rest.  Out: see PutState.
  void Reset() {
    world_->ResetTime();
    world_->SetSimTime(gazebo::common::Time(packet_.Take<double>() + dt_));
    diverged_.clear();
    contacts_.Clear();
    wrenches_.clear();
    while (!attached_.empty()) Detach(attached_.begin()->first);
    // From where all joints are at zero, since ODE takes the shorter way to an angle.
    for (const auto& [link, pose] : poses_at_zero_) Place(link, pose);
    for (const Drive& drive : drives_) drive.joint->Position(0);
    for (Drive& drive : drives_) drive.position = packet_.Take<double>();
    for (const Drive& drive : drives_) Place(drive.child, packet_.TakePose());
    for (const Rack& rack : racks_) rack.Place();
    for (const auto& object : objects_) {
      const auto pose = packet_.TakePose();
      if (Exists(object)) Place(object, pose);
    }
    dJointGroupEmpty(gear_joints_);
    world_->Physics()->Reset();
    BeginAnswer();
    PutState();
  }

  static void Place(const gazebo::physics::EntityPtr& entity, const Pose3d& pose) {
    entity->SetWorldPose(pose);
    if (const auto model = boost::dynamic_pointer_cast<gazebo::physics::Model>(entity))
      model->ResetPhysicsStates();
    else if (const auto link = boost::dynamic_pointer_cast<gazebo::physics::Link>(entity))
      link->ResetPhysicsStates();
  }

  /// In: name of the robot, with all joints at zero; n; of each joint its name and
  /// armature [kg·m²]; g; of each gear or rack the numbers of its second and first
  /// joint, and its multiplier.  Out: the world's gravity [m/s²].
  void Bind() {
    const auto robot = Model(packet_.TakeText());
    std::vector<Drive> drives;
    for (auto n = packet_.Take<std::uint32_t>(); n > 0; --n) {
      const std::string name = packet_.TakeText();
      const auto joint = robot->GetJoint(name);
      if (!joint)
        throw std::runtime_error("Gazebo's model has no joint '" + name + "'");
      const double armature = packet_.Take<double>();
      drives.emplace_back(joint);
      if (armature > 0.0) {
        joint->SetEffortLimit(0, -1.0);  // both are left to tool0's drives
        joint->SetVelocityLimit(0, -1.0);
        drives.back().AddArmature(armature, dt_, Ode());
      }
    }
    std::vector<Gear> gears;
    std::vector<Rack> racks;
    for (auto g = packet_.Take<std::uint32_t>(); g > 0; --g) {
      const Drive* second = &drives.at(packet_.Take<std::uint32_t>());
      const Drive* first = &drives.at(packet_.Take<std::uint32_t>());
      const double multiplier = packet_.Take<double>();
      if (first->turns) gears.push_back({first, second, multiplier});
      else racks.emplace_back(first, second, multiplier, Ode());
    }
    const auto physics = world_->Physics();
    physics->SetMaxStepSize(dt_);
    if (auto step = static_cast<double*>(::dlsym(RTLD_DEFAULT, "tool0_step")))
      *step = dt_;  // see preload.cc
    physics->SetRealTimeUpdateRate(0.0);
    // The iterative solver would leave errors that fingers on a stiff drive amplify;
    // for a robot the direct one is faster, too.
    physics->SetParam("solver_type", std::string("world"));
    for (const auto& model : world_->Models()) AddFrictionSlip(model);
    poses_at_zero_.clear();
    for (const auto& link : robot->GetLinks())
      poses_at_zero_.emplace_back(link, link->WorldPose());
    drives_.swap(drives);
    gears_.swap(gears);
    racks_.swap(racks);
    robot_ = robot;
    BeginAnswer();
    packet_.Put(world_->Gravity());
  }

  /// Lets friction yield a little.  Two flat faces touch in more points than it takes to
  /// hold them, and ODE's direct solver gives up on rows that say the same.
  static void AddFrictionSlip(const gazebo::physics::ModelPtr& model) {
    for (const auto& link : model->GetLinks())
      for (const auto& collision : link->GetCollisions()) {
        const auto surface = boost::dynamic_pointer_cast<gazebo::physics::ODESurfaceParams>(
            collision->GetSurface());
        if (!surface) continue;
        surface->slip1 = std::max(surface->slip1, kFrictionSlip);
        surface->slip2 = std::max(surface->slip2, kFrictionSlip);
      }
  }

  /// Out: of each object, in the order of their coming, its pose in the world [m,
  /// quaternion w x y z], the velocity of its origin [m/s], the angular one [rad/s].
  void Objects() {
    BeginAnswer();
    for (const auto& object : objects_) {
      const auto link = Exists(object) ? object->GetLinks().front() : nullptr;
      packet_.Put(object->WorldPose());
      packet_.Put(link ? link->WorldLinearVel() : Vector3d::Zero);
      packet_.Put(link ? link->WorldAngularVel() : Vector3d::Zero);
    }
  }

  /// Returns whether nobody else deleted the object, which leaves it without links.
  static bool Exists(const gazebo::physics::ModelPtr& object) {
    return !object->GetLinks().empty();
  }

  /// In: name of an object, pose, velocity of its origin [m/s], angular one [rad/s].
  void PlaceObject() {
    const auto object = Model(packet_.TakeText());
    Detach(object->GetName());
    Place(object, packet_.TakePose());
    const auto link = object->GetLinks().front();
    const auto center = link->WorldCoGPose().Pos() - link->WorldPose().Pos();
    const auto linear = packet_.TakeVector(), angular = packet_.TakeVector();
    link->SetLinearVel(linear + angular.Cross(center));  // ODE's is the centre's
    link->SetAngularVel(angular);
    world_->EnableAllModels();  // what slept on it would stay in the air
    BeginAnswer();
  }

  /// In: how many touches have been told already.  Out: how many are told here, how many
  /// are left; of each pair of shapes that touched in the last step, the names of the first
  /// one's model and of itself, the same of the second, and a ContactSum.  None at
  /// the first time, which makes it look from then on.  So of each object that is attached:
  /// the robot and the link that holds it, the object, and nothing.
  void Contacts() {
    const auto known = packet_.Take<std::uint32_t>();
    if (!contacts_.IsOn()) {
      contacts_.SwitchOn();
      world_->EnableAllModels();  // who sleeps touches nobody
    }
    BeginAnswer();
    const std::size_t at = packet_.Size();
    std::uint32_t all = 0, told = 0, left = 0;
    packet_.Put(told), packet_.Put(left);
    const auto tell = [&](const std::array<std::string, 4>& words, double weight,
                          const std::array<Vector3d, 3>& vectors) {
      if (all++ < known) return;
      std::size_t size = 10 * sizeof(double);
      for (const auto& word : words) size += word.size() + 1;
      if (left > 0 || size > packet_.Left()) return void(++left);
      for (const auto& word : words) packet_.PutText(word);
      packet_.Put(weight);
      for (const auto& vector : vectors) packet_.Put(vector);
      ++told;
    };
    for (const ContactSum& touch : contacts_.Sums()) {
      const auto [first, second] = touch.Shapes();
      if (!first) continue;
      tell({first->GetModel()->GetName(), first->GetName(), second->GetModel()->GetName(),
            second->GetName()},
           touch.weight, {touch.moment, touch.force, touch.torque});
    }
    for (const auto& [name, attached] : attached_) {
      const dBodyID body = dJointGetBody(attached.joint, 0);
      const Vector3d force = From(attached.feedback.f1);
      const double weight = force.Length();
      if (!body || !(weight > 0.0)) continue;
      const Vector3d center = From(dBodyGetPosition(body));
      tell({robot_->GetName(), attached.link, name, ""}, weight,
           {center * weight, force, From(attached.feedback.t1) + center.Cross(force)});
    }
    packet_.Overwrite(at, told), packet_.Overwrite(at + sizeof told, left);
  }

  /// In: name of an object that moves, name of the robot's link that it is fixed to as it
  /// is, or none if that never moves; and what the URDF calls that.
  void Attach() {
    const auto object = Model(packet_.TakeText());
    const std::string name = packet_.TakeText();
    const std::string called = packet_.TakeText();
    const auto link = name.empty() ? nullptr : robot_->GetLink(name);
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
    const dJointID joint = dJointCreateFixed(Ode(), 0);
    dJointAttach(joint, body, link ? BodyOf(link) : nullptr);
    dJointSetFixed(joint);
    dBodyEnable(body);
    Attached& attached = attached_[object->GetName()] = {joint, called, {}};
    dJointSetFeedback(joint, &attached.feedback);
    BeginAnswer();
  }

  /// Lets an object go that may be attached, and may be gone.
  void Detach(const std::string& name) {
    const auto found = attached_.find(name);
    if (found == attached_.end()) return;
    const dJointID joint = found->second.joint;
    if (const dBodyID body = dJointGetBody(joint, 0)) dBodyEnable(body);
    dJointDestroy(joint);
    attached_.erase(found);
  }

  /// In: name of a model, name of a link in it.
  gazebo::physics::LinkPtr TakeLink() {
    const auto model = Model(packet_.TakeText());
    const std::string name = packet_.TakeText();
    const auto link = model->GetLink(name);
    if (!link)
      throw std::runtime_error("Gazebo's '" + model->GetName() + "' has no link '" + name + "'");
    return link;
  }

  /// In: see TakeLink.  Out: where the link has its centre of mass, in the world [m].
  void Center() {
    const auto link = TakeLink();
    BeginAnswer();
    packet_.Put(link->WorldCoGPose().Pos());
  }

  /// In: n; of each wrench that acts from now on its link, see TakeLink, force [N] and
  /// torque [N·m].
  void HoldWrenches() {
    std::vector<Wrench> wrenches;
    for (auto n = packet_.Take<std::uint32_t>(); n > 0; --n) {
      const auto link = TakeLink();
      const auto force = packet_.TakeVector(), torque = packet_.TakeVector();
      wrenches.push_back({link, force, torque});
    }
    wrenches_.swap(wrenches);
    BeginAnswer();
  }

  /// In: name, file of the URDF or SDF, pose, whether it is an object as uint32.
  void Spawn() {
    const std::string name = packet_.TakeText(), file = packet_.TakeText();
    const Pose3d pose = packet_.TakePose();
    const bool is_object = packet_.Take<std::uint32_t>();
    if (const auto type = world_->Physics()->GetType(); type != "ode")
      throw std::runtime_error("the world's physics is '" + type +
                               "', but the robot needs <physics type=\"ode\">");
    RequireFree(name);
    std::ifstream stream(file);
    std::stringstream text;
    text << stream.rdbuf();
    if (!stream) throw std::runtime_error("cannot read " + file);
    const sdf::SDFPtr sdf(new sdf::SDF);
    sdf::init(sdf);
    if (!sdf::readString(text.str(), sdf) || !sdf->Root()->HasElement("model"))
      throw std::runtime_error("Gazebo finds no model in " + file);
    const auto model = sdf->Root()->GetElement("model");
    model->GetAttribute("name")->SetFromString(name);
    model->GetElement("pose")->Set(pose);
    world_->InsertModelSDF(*sdf);
    WaitUntil(
        [this, name, is_object] {
          const auto model = world_->ModelByName(name);
          if (!model) return false;
          AddFrictionSlip(model);
          if (is_object) objects_.push_back(model);
          return true;
        },
        "Gazebo did not take the model '" + name + "'");
  }

  /// Gazebo finds things by name alone, those in models, too: of two it finds the first.
  void RequireFree(const std::string& name) const {
    const auto taken = world_->BaseByName(name);
    if (!taken) return;
    const bool is_model = taken->HasType(gazebo::physics::Base::MODEL);
    const std::string full = taken->GetScopedName();
    throw std::runtime_error(
        is_model ? "the world has a model '" + name + "' already"
                 : "the name '" + name + "' is taken in Gazebo's world, by '" + full +
                       "', which is no model; choose another");
  }

  /// In: name of a model, not the robot's.
  ///
  /// A model that goes tells everybody so by a request, and the world does what that
  /// says, too: it removes what has the name by then.  It looks at requests now and then,
  /// and does so when it looks for the second time; until then no other may come.  Answers
  /// get lost when programs like `gz` come and go; it has looked long before kRequestsDone.
  void Delete() {
    const std::string name = packet_.TakeText();
    const auto is_it = [&name](const auto& object) { return object->GetName() == name; };
    const auto gone = std::remove_if(objects_.begin(), objects_.end(), is_it);
    if (gone == objects_.end()) Model(name);
    Detach(name);
    objects_.erase(gone, objects_.end());
    world_->RemoveModel(name);
    RequestEntityInfo(name);
    WaitUntil(
        [this, name, looks = 2, looked = Clock::now() + kRequestsDone]() mutable {
          if (Clock::now() > looked) return !world_->ModelByName(name);
          if (pending_request_) return false;
          if (--looks > 0) RequestEntityInfo(name);
          return looks == 0;
        },
        "Gazebo did not remove the model '" + name + "'");
  }

  /// Asks the world for something; it answers when it looks at requests.
  void RequestEntityInfo(const std::string& name) {
    gazebo::msgs::Request request;
    request.set_id(pending_request_ = kRequest);
    request.set_request("entity_info");
    request.set_data(name);
    requests_->Publish(request, true);
  }

  void OnResponse(ConstResponsePtr& response) {
    if (response->id() == pending_request_) pending_request_ = 0;
  }

  gazebo::physics::ModelPtr Model(const std::string& name) const {
    const auto model = world_->ModelByName(name);
    if (!model) throw std::runtime_error("the world has no model '" + name + "'");
    return model;
  }

  void WaitUntil(std::function<bool()> happened, std::string otherwise) {
    condition_ = std::move(happened);
    timeout_error_ = std::move(otherwise);
    deadline_ = Clock::now() + kModelTimeout;
  }

  /// Returns whether what was waited for has come, or will not.
  bool IsConditionSettled() {
    const bool happened = condition_();
    if (!happened && Clock::now() < deadline_) {
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
      return false;
    }
    condition_ = nullptr;
    world_->EnableAllModels();  // now, and not when the world next looks at requests
    BeginAnswer();
    if (!happened) PutError(timeout_error_);
    SendAnswer();
    return true;
  }

  /// Lets the world make a turn in which nothing moves and no time passes.
  void SkipStep() {
    world_->SetPhysicsEnabled(false);
    world_->SetSimTime(world_->SimTime() - gazebo::common::Time(dt_));
  }

  /// Moves again; forces that plugins added in vain must not add up.  What sleeps goes on
  /// sleeping: how often this is called is a matter of wall time.
  void Resume() {
    for (const auto& model : world_->Models())
      for (const auto& link : model->GetLinks()) {
        if (!link->GetEnabled()) continue;
        link->SetForce(Vector3d::Zero);
        link->SetTorque(Vector3d::Zero);
      }
    world_->SetPhysicsEnabled(true);
  }

  void Pause() {
    SkipStep();
    world_->Physics()->SetRealTimeUpdateRate(kIdleRate);
    world_->SetPaused(true);
  }

  void BeginAnswer() {
    packet_.Clear();
    packet_.Put(std::uint32_t{0});
  }

  void PutError(const std::string& why) {
    packet_.Clear();
    packet_.Put(std::uint32_t{1});
    packet_.Put(why);
  }

  void SendAnswer() {
    owes_answer_ = false;
    if (::send(socket_, packet_.Bytes(), packet_.Size(), MSG_NOSIGNAL) < 0) ::_exit(0);
  }

  /// Returns whether a packet came within `patience` [ms]; ends when none ever will.
  /// A loop at full speed answers at once: to be awake then saves 30 µs of waking.
  bool Receive(int patience) {
    const auto awake = Clock::now() + kSpinTime;
    ssize_t size;
    do size = ::recv(socket_, packet_.Buffer(), kMaxPacket, MSG_DONTWAIT);
    while (size < 0 && errno == EAGAIN && Clock::now() < awake);
    if (size < 0 && errno == EAGAIN) {
      pollfd waiting{socket_, POLLIN, 0};
      if (::poll(&waiting, 1, patience) == 0) return false;
      size = ::recv(socket_, packet_.Buffer(), kMaxPacket, 0);
    }
    if (size <= 0) ::_exit(0);
    packet_.Fill(size);
    return true;
  }

  [[noreturn]] static void Exit(const std::string& why) {
    std::cerr << "tool0's bridge: " << why << std::endl;
    ::_exit(1);
  }

  int socket_ = -1;
  double dt_ = 0.0;
  Packet packet_;
  gazebo::physics::WorldPtr world_;
  std::atomic<bool> has_world_{false}, owes_answer_{false};
  bool stepping_ = false;
  std::vector<Drive> drives_;
  std::vector<Gear> gears_;
  std::vector<Rack> racks_;
  std::vector<std::pair<gazebo::physics::LinkPtr, Pose3d>> poses_at_zero_;  // of the robot
  std::string diverged_;  // what was not finite after the last step, or empty
  const dJointGroupID gear_joints_ = dJointGroupCreate(0);
  std::vector<gazebo::physics::ModelPtr> objects_;
  gazebo::physics::ModelPtr robot_;
  std::map<std::string, Attached> attached_;  // by the object's name
  std::vector<Wrench> wrenches_;
  ContactRecorder contacts_;
  std::function<bool()> condition_;
  std::string timeout_error_;
  Clock::time_point deadline_;
  gazebo::event::ConnectionPtr created_, update_, updated_;
  gazebo::transport::NodePtr node_;
  gazebo::transport::PublisherPtr requests_;
  gazebo::transport::SubscriberPtr responses_;
  std::atomic<int> pending_request_{0};  // its number, or 0
};

GZ_REGISTER_SYSTEM_PLUGIN(Bridge)

}  // namespace tool0
