#pragma once
// The systemd of another host by D-Bus, through ssh (host_bus.hpp), and that of this host.
//
// A signal goes to the object of an invocation, /org/freedesktop/systemd1/unit/<32 digits>, which
// systemd has beside that of the unit's name: if another start of the unit runs when the call
// arrives, there is no such object.
//
// Threads: loop thread only, callbacks too.

#include "musher/controller/process/systemd.hpp"
#include "musher/transport/event_loop.hpp"

namespace musher {

// The loop must outlive the connections.
ConnectSystemd BySsh(transport::EventLoop& loop);

// The systemd of this host, by the socket of its D-Bus. Here the output of a unit may be a file:
// a descriptor is passed on (UnitStart::process).
ConnectSystemd BySocket(transport::EventLoop& loop, std::string socket);

}  // namespace musher
