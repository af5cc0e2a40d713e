// Adding models to the world and removing them.

#pragma once

#include <atomic>
#include <chrono>
#include <cstdint>
#include <fstream>
#include <functional>
#include <sstream>
#include <stdexcept>
#include <string>
#include <thread>
#include <utility>

#include <gazebo/msgs/msgs.hh>
#include <gazebo/physics/physics.hh>
#include <gazebo/transport/transport.hh>

#include "entities.h"
#include "objects.h"
#include "protocol.h"

namespace tool0 {

using ignition::math::Pose3d;

using Clock = std::chrono::steady_clock;

constexpr auto kModelTimeout = std::chrono::seconds(10);  // to add or remove a model
constexpr auto kRequestsDone = std::chrono::milliseconds(1500);  // twice, at 5 Hz
constexpr int kRequest = 1 << 20;  // Gazebo's own are below 10000

/// Adds models to the world and removes them.  The world must go on until a change is
/// settled.
class ModelChanges {
 public:
  void Open(const gazebo::physics::WorldPtr& world) {
    world_ = world;
    node_.reset(new gazebo::transport::Node);
    node_->Init(world->Name());
    requests_ = node_->Advertise<gazebo::msgs::Request>("~/request");
    responses_ = node_->Subscribe("~/response", &ModelChanges::OnResponse, this);
  }

  /// Adds a model to the world, and to the objects if it is one; see kSpawn.
  void Spawn(Packet& packet, Objects& objects) {
    const std::string name = packet.TakeText(), file = packet.TakeText();
    const Pose3d pose = packet.TakePose();
    const bool is_object = packet.Take<std::uint32_t>();
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
        [this, name, is_object, &objects] {
          const auto model = world_->ModelByName(name);
          if (!model) return false;
          AddFrictionSlip(model);
          if (is_object) objects.Add(model);
          return true;
        },
        "Gazebo did not take the model '" + name + "'");
  }

  /// Removes a model that is not the robot's; see kDelete.
  ///
  /// A model that goes tells everybody so by a request, and the world does what that
  /// says, too: it removes what has the name by then.  It looks at requests now and then,
  /// and does so when it looks for the second time; until then no other may come.  Answers
  /// get lost when programs like `gz` come and go; it has looked long before kRequestsDone.
  void Delete(const std::string& name, Objects& objects) {
    if (!objects.Has(name)) FindModel(world_, name);
    objects.Remove(name);
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

  /// Returns whether a change has begun and is not settled.
  bool IsWaiting() const { return static_cast<bool>(condition_); }

  /// Returns whether the change is settled; if so, the packet is the answer: an error if the
  /// world did not make the change in time.
  bool IsSettled(Packet& packet) {
    const bool happened = condition_();
    if (!happened && Clock::now() < deadline_) {
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
      return false;
    }
    condition_ = nullptr;
    world_->EnableAllModels();  // now, and not when the world next looks at requests
    packet.BeginAnswer();
    if (!happened) packet.PutError(timeout_error_);
    return true;
  }

 private:
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

  void WaitUntil(std::function<bool()> happened, std::string otherwise) {
    condition_ = std::move(happened);
    timeout_error_ = std::move(otherwise);
    deadline_ = Clock::now() + kModelTimeout;
  }

  gazebo::physics::WorldPtr world_;
  std::function<bool()> condition_;
  std::string timeout_error_;
  Clock::time_point deadline_;
  gazebo::transport::NodePtr node_;
  gazebo::transport::PublisherPtr requests_;
  gazebo::transport::SubscriberPtr responses_;
  std::atomic<int> pending_request_{0};  // its number, or 0
};

}  // namespace tool0
