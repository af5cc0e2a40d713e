// The bridge: a plugin of gzserver that hands the clock of the world to tool0.
//
// gzserver loads it beside any world (`gzserver -s`).  It connects to the socket that
// TOOL0_BRIDGE names, and answers requests there (protocol.h).  A step is a request, too:
// the efforts come in, the world makes one step, the new state goes out.  While nothing
// is asked the world is paused, so that gzclient stays alive; when the socket closes, the
// server ends.
//
// The headers beside this file have one idea each.  They are compiled with this file as one
// unit, because the compiler needs most of its time for Gazebo's own headers.

#include <dlfcn.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <cstdint>
#include <cstdlib>
#include <exception>
#include <stdexcept>
#include <string>
#include <thread>

#include <gazebo/common/Console.hh>
#include <gazebo/common/Events.hh>
#include <gazebo/common/Plugin.hh>
#include <gazebo/gazebo_config.h>
#include <gazebo/physics/physics.hh>

#include "connection.h"
#include "contacts.h"
#include "entities.h"
#include "models.h"
#include "objects.h"
#include "protocol.h"
#include "robot.h"
#include "wrenches.h"

namespace tool0 {

using ignition::math::Vector3d;

constexpr int kIdleAfter = 20;       // [ms] without a request
constexpr double kIdleRate = 100.0;  // [Hz] of a paused world's loop

class Bridge : public gazebo::SystemPlugin {
 public:
  ~Bridge() override { ::_exit(0); }  // its threads refer to it

  void Load(int, char**) override {
    connection_.Open(std::getenv("TOOL0_BRIDGE"));
    packet_.Put(kVersion);
    packet_.Put(std::string(GAZEBO_VERSION_FULL));
    SendAnswer();
    if (!connection_.Receive(packet_, 5000)) Exit("nobody answers");
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
    models_.Open(world_);
    has_world_ = true;
  }

  /// Ends the server with the socket; wakes a paused world when something is asked, or
  /// was: anybody may pause it, even in the middle of a step.
  void WatchSocket() {
    for (;;) {
      const bool is_paused = has_world_ && world_->IsPaused();
      const bool is_asked = connection_.Watch(is_paused);
      if (is_paused && (is_asked || owes_answer_)) Unpause();
    }
  }

  /// Answers requests until one needs the world to go on.
  void ServeRequests() {
    if (!world_->PhysicsEnabled()) Resume();
    if (models_.IsWaiting()) {
      if (!models_.IsSettled(packet_)) return SkipStep();
      SendAnswer();
    }
    if (stepping_) {
      stepping_ = false;
      PutState();
      SendAnswer();
    }
    for (;;) {
      if (!connection_.Receive(packet_, kIdleAfter)) return Pause();
      try {
        owes_answer_ = HandleRequest(static_cast<Kind>(packet_.Take<std::uint32_t>()));
        if (stepping_) return;
        if (owes_answer_) return SkipStep();
      } catch (const std::exception& error) {
        packet_.PutError(error.what());
      }
      SendAnswer();
    }
  }

  /// Returns whether the world must go on before there is an answer; otherwise, the packet
  /// is the answer.
  bool HandleRequest(Kind kind) {
    switch (kind) {
      case kStep: return Step();
      case kReset: Reset(); return false;
      case kBind: Bind(); return false;
      case kObjects: packet_.BeginAnswer(), objects_.Put(packet_); return false;
      case kSpawn: models_.Spawn(packet_, objects_); return true;
      case kDelete: models_.Delete(packet_.TakeText(), objects_); return true;
      case kPlace: objects_.Move(packet_, world_); break;
      case kContacts: Contacts(); return false;
      case kAttach: objects_.Attach(packet_, world_, robot_.Model()); break;
      case kDetach: objects_.Detach(packet_.TakeText()); break;
      case kCenter: Center(); return false;
      case kWrenches: wrenches_.Hold(packet_, world_); break;
      case kBrakes: robot_.SetBrakes(packet_, world_); break;
      default: throw std::runtime_error("unknown request");
    }
    packet_.BeginAnswer();
    return false;
  }

  bool Step() {
    if (!diverged_.empty()) {
      PutState();
      return false;
    }
    robot_.ApplyEfforts(packet_);
    wrenches_.Apply();
    robot_.UpdateTeeth(world_, dt_);
    contacts_.BeginStep();
    return stepping_ = true;
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
    const auto joint = robot_.LostJoint(model);
    return joint ? "joint " + joint->GetName() : "object " + model->GetName();
  }

  /// Answers with the state, or with what is not finite; see kStep.
  void PutState() {
    packet_.BeginAnswer();
    if (diverged_.empty()) return robot_.PutState(packet_);
    robot_.PutNoState(packet_);
    packet_.Put(diverged_);
  }

  void Reset() {
    world_->ResetTime();
    world_->SetSimTime(gazebo::common::Time(packet_.Take<double>() + dt_));
    diverged_.clear();
    contacts_.Clear();
    wrenches_.Clear();
    objects_.DetachAll();
    robot_.Reset(packet_);
    objects_.Reset(packet_);
    robot_.RemoveTeeth();
    world_->Physics()->Reset();
    PutState();
  }

  void Bind() {
    robot_.Bind(packet_, world_, dt_);
    const auto physics = world_->Physics();
    physics->SetMaxStepSize(dt_);
    if (auto step = static_cast<double*>(::dlsym(RTLD_DEFAULT, "tool0_step")))
      *step = dt_;  // see preload.cc
    physics->SetRealTimeUpdateRate(0.0);
    // The iterative solver would leave errors that fingers on a stiff drive amplify;
    // for a robot the direct one is faster, too.
    physics->SetParam("solver_type", std::string("world"));
    for (const auto& model : world_->Models()) AddFrictionSlip(model);
    packet_.BeginAnswer();
    packet_.Put(world_->Gravity());
  }

  void Contacts() {
    const auto known = packet_.Take<std::uint32_t>();
    if (!contacts_.IsOn()) {
      contacts_.SwitchOn();
      world_->EnableAllModels();  // who sleeps touches nobody
    }
    ContactAnswer answer(packet_, known);
    contacts_.Put(answer);
    objects_.PutHeld(answer, robot_.Model());
    answer.Finish();
  }

  void Center() {
    const auto link = TakeLink(packet_, world_);
    packet_.BeginAnswer();
    packet_.Put(link->WorldCoGPose().Pos());
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

  void Unpause() {
    world_->Physics()->SetRealTimeUpdateRate(0.0);
    world_->SetPaused(false);
  }

  void SendAnswer() {
    owes_answer_ = false;
    connection_.Send(packet_);
  }

  Connection connection_;
  double dt_ = 0.0;
  Packet packet_;
  gazebo::physics::WorldPtr world_;
  std::atomic<bool> has_world_{false}, owes_answer_{false};
  bool stepping_ = false;
  std::string diverged_;  // what was not finite after the last step, or empty
  Robot robot_;
  Objects objects_;
  Wrenches wrenches_;
  ContactRecorder contacts_;
  ModelChanges models_;
  gazebo::event::ConnectionPtr created_, update_, updated_;
};

GZ_REGISTER_SYSTEM_PLUGIN(Bridge)

}  // namespace tool0
