// Preloaded into gzserver and gzclient: keeps them on this machine, and tied to us.
//
// Gazebo's transport listens on every network interface; here it gets the loopback
// one, unless TOOL0_LISTEN is "all".  And when the pipe that TOOL0_LIFELINE numbers
// closes, because the process that started them is gone, however it went, they end.

#include <arpa/inet.h>
#include <dlfcn.h>
#include <netinet/in.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <cstdlib>
#include <cstring>
#include <thread>

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

namespace {

[[gnu::constructor]] void HoldOn() {
  const char* number = std::getenv("TOOL0_LIFELINE");
  if (!number) return;
  std::thread([fd = std::atoi(number)] {
    pollfd lifeline{fd, 0, 0};  // only its end counts
    while (::poll(&lifeline, 1, -1) < 0) {
    }
    ::_exit(0);
  }).detach();
}

}  // namespace
