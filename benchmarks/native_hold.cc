// Efforts computed in C++: what lock-step with Python is measured against.
//
// Preloaded into gzserver, this stands between the bridge and its socket.  Asked by a
// packet of a kind that the bridge does not know, it answers the bridge's own calls for
// a number of steps: a request to step is there at once, with efforts that hold the
// pose.  The world, its solver and the bridge's work are the same; what is left out is
// the way through the kernel to Python and back, and what Python does there.
//
// In: uint32 kind, uint32 steps, uint32 n; then n times: effort at rest [N·m], position
// [rad], stiffness [N·m/rad], damping [N·m·s/rad].  Out: uint32 0, double seconds.

#include <dlfcn.h>
#include <poll.h>
#include <sys/socket.h>
#include <sys/types.h>

#include <chrono>
#include <cstdint>
#include <cstring>
#include <vector>

namespace {

using Clock = std::chrono::steady_clock;
constexpr std::uint32_t kHold = 1000, kStep = 1;

struct Joint {
  double effort, position, stiffness, damping;
};

int hold_socket = -1;
std::uint32_t left;
std::vector<Joint> joints;
std::vector<double> state;  // positions, velocities
Clock::time_point start;

template <typename F>
F Next(const char* name) {
  return reinterpret_cast<F>(dlsym(RTLD_NEXT, name));
}

ssize_t NextStep(char* packet) {
  const std::size_t n = joints.size();
  std::memcpy(packet, &kStep, 4);
  for (std::size_t i = 0; i < n; ++i) {
    const Joint& joint = joints[i];
    const double effort = joint.effort +
                          joint.stiffness * (joint.position - state[i]) -
                          joint.damping * state[n + i];
    std::memcpy(packet + 4 + 8 * i, &effort, 8);
  }
  return 4 + 8 * n;
}

void Begin(int socket, const char* packet) {
  std::uint32_t n;
  std::memcpy(&left, packet + 4, 4);
  std::memcpy(&n, packet + 8, 4);
  joints.resize(n);
  std::memcpy(joints.data(), packet + 12, n * sizeof(Joint));
  state.assign(2 * n, 0.0);
  for (std::size_t i = 0; i < n; ++i) state[i] = joints[i].position;
  hold_socket = socket;
  start = Clock::now();
}

}  // namespace

extern "C" int poll(pollfd* fds, nfds_t n, int timeout) {
  static const auto real = Next<int (*)(pollfd*, nfds_t, int)>("poll");
  if (n != 1 || fds->fd != hold_socket || !(fds->events & POLLIN))
    return real(fds, n, timeout);
  fds->revents = POLLIN;
  return 1;
}

extern "C" ssize_t recv(int socket, void* packet, size_t room, int flags) {
  static const auto real = Next<ssize_t (*)(int, void*, size_t, int)>("recv");
  const auto bytes = static_cast<char*>(packet);
  if (socket == hold_socket) return NextStep(bytes);
  const ssize_t size = real(socket, packet, room, flags);
  std::uint32_t kind = 0;
  if (size >= 12) std::memcpy(&kind, bytes, 4);
  if (kind != kHold) return size;
  Begin(socket, bytes);
  return NextStep(bytes);
}

extern "C" ssize_t send(int socket, const void* packet, size_t size, int flags) {
  static const auto real = Next<ssize_t (*)(int, const void*, size_t, int)>("send");
  if (socket != hold_socket) return real(socket, packet, size, flags);
  std::memcpy(state.data(), static_cast<const char*>(packet) + 4, 8 * state.size());
  if (--left > 0) return size;
  hold_socket = -1;
  const double seconds = std::chrono::duration<double>(Clock::now() - start).count();
  char answer[12] = {};
  std::memcpy(answer + 4, &seconds, 8);
  real(socket, answer, sizeof answer, flags);
  return size;
}
