#pragma once
// The network interfaces of this host.
//
// Threads: any.

namespace musher::transport {

// Whether a network interface other than the loopback is up and has an IPv4 address.
bool HasNetwork();

}  // namespace musher::transport
