// The bridge's end of the socket.  The server ends with the socket, since nobody could
// end a server without one.

#pragma once

#include <poll.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include <cerrno>
#include <chrono>
#include <cstring>
#include <iostream>
#include <string>

#include "protocol.h"

namespace tool0 {

using Clock = std::chrono::steady_clock;

constexpr auto kSpinTime = std::chrono::microseconds(60);  // after an answer

[[noreturn]] inline void Exit(const std::string& why) {
  std::cerr << "tool0's bridge: " << why << std::endl;
  ::_exit(1);
}

/// A SOCK_SEQPACKET of the Unix kind: one packet in, one packet out.
class Connection {
 public:
  void Open(const char* path) {
    sockaddr_un address{};
    address.sun_family = AF_UNIX;
    if (!path || std::strlen(path) >= sizeof address.sun_path)
      Exit("TOOL0_BRIDGE must name the socket");
    std::strcpy(address.sun_path, path);
    socket_ = ::socket(AF_UNIX, SOCK_SEQPACKET | SOCK_CLOEXEC, 0);
    if (::connect(socket_, reinterpret_cast<sockaddr*>(&address), sizeof address))
      Exit(std::string("cannot connect to ") + path + ": " + std::strerror(errno));
  }

  void Send(const Packet& packet) const {
    if (::send(socket_, packet.Bytes(), packet.Size(), MSG_NOSIGNAL) < 0) ::_exit(0);
  }

  /// Returns whether a packet came within `patience` [ms]; ends when none ever will.
  /// A loop at full speed answers at once: to be awake then saves 30 µs of waking.
  bool Receive(Packet& packet, int patience) const {
    const auto awake = Clock::now() + kSpinTime;
    ssize_t size;
    do size = ::recv(socket_, packet.Buffer(), kMaxPacket, MSG_DONTWAIT);
    while (size < 0 && errno == EAGAIN && Clock::now() < awake);
    if (size < 0 && errno == EAGAIN) {
      pollfd waiting{socket_, POLLIN, 0};
      if (::poll(&waiting, 1, patience) == 0) return false;
      size = ::recv(socket_, packet.Buffer(), kMaxPacket, 0);
    }
    if (size <= 0) ::_exit(0);
    packet.Fill(size);
    return true;
  }

  /// Waits 10 ms, or until the socket closes, which ends the server.  If told to look for
  /// requests, waits no longer than until there is one, and returns whether there is.
  bool Watch(bool looks_for_requests) const {
    pollfd waiting{socket_, static_cast<short>(looks_for_requests ? POLLIN : 0), 0};
    ::poll(&waiting, 1, 10);
    if (waiting.revents & (POLLHUP | POLLERR)) ::_exit(0);
    return waiting.revents & POLLIN;
  }

 private:
  int socket_ = -1;
};

}  // namespace tool0
