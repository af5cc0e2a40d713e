// Preloaded into gzserver and gzclient: keeps them on this machine, limits the speed at
// which ODE separates bodies that overlap, and reports contacts to the bridge.
//
// Gazebo's transport listens on every network interface; here it gets the loopback
// one, unless TOOL0_LISTEN is "all".

#include <arpa/inet.h>
#include <dlfcn.h>
#include <netinet/in.h>
#include <sys/socket.h>

#include <algorithm>
#include <cstdlib>
#include <cstring>

#include <gazebo/physics/ode/ode_inc.h>

constexpr double kPushOut = 0.5;  // [m/s] at most, by which ODE undoes an overlap

extern "C" double tool0_step = 0.0;  // [s] of the world; the bridge tells

/// Called for each contact that is made, once somebody asks the bridge for contacts.
extern "C" void (*tool0_touched)(dJointID, const dContactGeom*) = nullptr;

extern "C" int bind(int fd, const sockaddr* address, socklen_t size) noexcept {
  using Bind = int (*)(int, const sockaddr*, socklen_t);
  static const auto real = reinterpret_cast<Bind>(::dlsym(RTLD_NEXT, "bind"));
  const char* listen = std::getenv("TOOL0_LISTEN");
  const bool is_inet = address && address->sa_family == AF_INET;
  if (!is_inet || size < sizeof(sockaddr_in) || (listen && !std::strcmp(listen, "all")))
    return real(fd, address, size);
  sockaddr_in local;
  std::memcpy(&local, address, sizeof local);
  if (local.sin_addr.s_addr == htonl(INADDR_ANY))
    local.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  return real(fd, reinterpret_cast<const sockaddr*>(&local), sizeof local);
}

/// ODE's direct solver overlooks <max_vel>: it undoes an overlap, however deep, in one
/// step or two, at 20 m/s for 2 cm.  Here such a contact gets the damper that is missing.
/// Its spring, soft_erp / (step * soft_cfm), stays as it is.
extern "C" dJointID dJointCreateContact(dWorldID world, dJointGroupID group,
                                        const dContact* contact) {
  static const auto real = reinterpret_cast<decltype(&dJointCreateContact)>(
      ::dlsym(RTLD_NEXT, "dJointCreateContact"));
  dContact calm = *contact;
  dSurfaceParameters& surface = calm.surface;
  const double most = kPushOut * tool0_step / std::max(calm.geom.depth, 1e-12);
  if (tool0_step > 0.0 && surface.mode & dContactSoftERP && surface.soft_erp > most) {
    surface.soft_cfm *= most / surface.soft_erp;
    surface.soft_erp = most;
  }
  const dJointID joint = real(world, group, &calm);
  if (tool0_touched) tool0_touched(joint, &calm.geom);
  return joint;
}
